// Who may log in.
import { get, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { dateTime } from '../../core/format';
import { dialog, toast } from '../../core/overlay';
import type { Page, Role } from '../../core/page';
import { button, choice, failurePanel, field, runBusy, showAtField, showFailure, table, type Column, type Field } from '../../core/ui';
import { tAdmin as t } from '../../words/admin';

interface User {
  name: string;
  role: Role;
  enabled: boolean;
  has_pin: boolean;
  has_totp: boolean;
  created_ms: number;
  last_login_ms: number | null;
  totp_uri?: string;
}

const roleWords = { operator: 'role_operator', technician: 'role_technician', admin: 'role_admin' } as const;
const roles = Object.keys(roleWords) as (keyof typeof roleWords)[];

export const usersPage: Page = {
  path: '/admin/users',
  roles: ['admin'],
  title: () => t('nav_users'),
  mount(root) {
    const list = h('div', null);
    const edit = h('div', null);
    let gone = false;
    const load = async () => {
      try {
        const { users } = await get<{ users: User[] }>('/api/users');
        if (!gone) replace(list, userTable(users, edit, () => void load()));
      } catch (error) {
        if (!gone) replace(list, failurePanel(error, () => void load()));
      }
    };
    void load();
    replace(root, h('div', { class: 'stack' }, h('h1', null, t('users_title')), list, edit, newUser(() => void load())));
    return () => {
      gone = true;
    };
  },
};

function userTable(users: User[], edit: HTMLElement, again: () => void): HTMLElement {
  const columns: Column<User>[] = [
    { head: t('name'), cell: (user) => user.name },
    { head: t('role'), cell: (user) => (user.role === 'none' ? '' : t(roleWords[user.role])) },
    { head: t('state'), cell: (user) => h('span', { class: `badge ${user.enabled ? 'good' : 'warn'}` }, user.enabled ? t('enabled') : t('disabled')) },
    { head: t('ways'), cell: (user) => [t('password'), user.has_pin ? t('pin_yes') : '', user.has_totp ? t('totp_yes') : ''].filter(Boolean).join(' · ') },
    { head: t('last_login'), cell: (user) => (user.last_login_ms ? dateTime(user.last_login_ms) : t('never')) },
    { head: t('change'), cell: (user) => h('span', { class: 'row' }, ...userButtons(user, edit, again)) },
  ];
  return table(t('users_title'), columns, users).root;
}

function userButtons(user: User, edit: HTMLElement, again: () => void): HTMLElement[] {
  const address = `/api/users/${encodeURIComponent(user.name)}`;
  const change = button(t('change'), () => {
    replace(edit, changeUser(user, again));
    edit.querySelector('input')?.focus();
  }, { label: `${t('change')}: ${user.name}` });
  const lock = button(user.enabled ? t('disable') : t('enable'), async () => (await post(address, { enabled: !user.enabled }), again()), { label: `${user.enabled ? t('disable') : t('enable')}: ${user.name}` });
  const remove = button(
    t('remove'),
    async () => {
      const answer = await dialog(t('remove_title', { name: user.name }), [h('p', null, t('remove_text'))], [
        { answer: 'no', text: t('cancel'), kind: 'primary' },
        { answer: 'yes', text: t('remove'), kind: 'danger' },
      ]);
      if (answer !== 'yes') return;
      await post(`${address}/remove`);
      again();
    },
    { kind: 'danger', label: `${t('remove')}: ${user.name}` },
  );
  return [change, lock, remove];
}

/** A form whose failures go to their fields. */
function userForm(title: string, fields: Field[], rest: HTMLElement[], send: () => Promise<void>): HTMLElement {
  const save = h('button', { type: 'submit', class: 'button primary' }, t('save'));
  const act = async () => {
    const empty = fields.filter((one) => one.input.required && one.input.value === '');
    for (const one of fields) one.error(empty.includes(one) ? t('required') : null);
    if (empty[0]) return empty[0].input.focus();
    try {
      await send();
    } catch (error) {
      if (!showAtField(error, fields)) showFailure(error);
    }
  };
  return h(
    'form',
    { class: 'card stack', novalidate: true, onsubmit: (event: Event) => (event.preventDefault(), void runBusy(save, act)) },
    h('h2', null, title),
    h('div', { class: 'columns' }, ...fields.map((one) => one.root), ...rest),
    h('div', { class: 'row end' }, save),
  );
}

function newUser(again: () => void): HTMLElement {
  const name = field(t('name'), 'name', { required: true, maxlength: 64 });
  const password = field(t('password'), 'password', { type: 'password', required: true, autocomplete: 'new-password', maxlength: 256, hint: t('password_hint') });
  const role = choice(t('role'), 'role', roles.map((one) => [one, t(roleWords[one])] as const), 'operator');
  const form = userForm(t('add_user'), [name, password], [role.root], async () => {
    await post('/api/users', { name: name.value, role: role.input.value, password: password.input.value });
    name.input.value = password.input.value = '';
    toast(t('saved'), 'good');
    again();
  });
  return form;
}

function changeUser(user: User, again: () => void): HTMLElement {
  const address = `/api/users/${encodeURIComponent(user.name)}`;
  const password = field(t('password_new'), 'password', { type: 'password', autocomplete: 'new-password', maxlength: 256, hint: t('password_hint') });
  const pin = field(t('pin'), 'pin', { type: 'password', inputmode: 'numeric', maxlength: 12 });
  const role = choice(t('role'), 'role', roles.map((one) => [one, t(roleWords[one])] as const), user.role);
  const secret = h('div', { role: 'status' });
  const totp = button(user.has_totp ? t('totp_off') : t('totp_new'), async () => {
    const changed = await post<User>(address, { totp: user.has_totp ? 'off' : 'new' });
    if (changed.totp_uri) replace(secret, h('p', { class: 'note' }, t('totp_secret'), h('br'), h('code', { class: 'secret' }, secretOf(changed.totp_uri)), h('br'), h('code', { class: 'small secret' }, changed.totp_uri)));
    again();
  });
  const form = userForm(`${t('change')}: ${user.name}`, [password, pin], [role.root, h('div', null, totp, secret)], async () => {
    const body = { ...(role.input.value === user.role ? {} : { role: role.input.value }), ...(password.input.value ? { password: password.input.value } : {}), ...(pin.input.value ? { pin: pin.input.value } : {}) };
    await post(address, body);
    password.input.value = pin.input.value = '';
    toast(t('saved'), 'good');
    again();
  });
  return form;
}

/** The key of an otpauth address in groups of four, as it is typed into an authenticator. */
export function secretOf(uri: string): string {
  const secret = /[?&]secret=([A-Z2-7]+)/i.exec(uri)?.[1] ?? '';
  return secret.replace(/(.{4})(?=.)/g, '$1 ');
}
