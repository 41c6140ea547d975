// Log in, by password (and code) or, on the booth's own screen, by PIN; and the very first account.
import { h, replace } from '../../core/dom';
import type { Page } from '../../core/page';
import { endedBecause, login, makeFirstAccount, session } from '../../core/session';
import { button, failurePanel, field, runBusy, showAtField, tabs, type Field } from '../../core/ui';
import { tShell } from '../../words/shell';

const kLeastPassword = 12;
const kLongestPin = 12;

export const loginPage: Page = {
  path: '/login',
  roles: ['none'],
  title: null,
  mount(root) {
    const setup = session.value?.setup_needed === true;
    const methods = [{ label: tShell('with_password'), panel: passwordForm }];
    if (session.value?.local) methods.push({ label: tShell('with_pin'), panel: pinForm });
    replace(
      root,
      h(
        'div',
        { class: 'login' },
        h('h1', null, setup ? tShell('setup_title') : tShell('login_title')),
        endedBecause.value ? h('div', { class: 'note warn' }, h('strong', null, tShell('session_over')), ' ', tShell('session_over_do')) : null,
        h('div', { class: 'card' }, setup ? setupForm() : methods.length > 1 ? tabs(tShell('login'), methods) : passwordForm()),
      ),
    );
    return () => {};
  },
};

/** A form that is sent by its button and by Enter; failures go to their field, or into `failed`. */
function form(parts: (HTMLElement | null)[], send: HTMLButtonElement, fields: Field[], act: () => Promise<void>): HTMLElement {
  const failed = h('div', null);
  return h(
    'form',
    {
      class: 'stack',
      novalidate: true,
      onsubmit: (event: Event) => {
        event.preventDefault();
        failed.replaceChildren();
        if (!allFilled(fields)) return;
        void runBusy(send, () => act().catch((error) => void (showAtField(error, fields) || replace(failed, failurePanel(error)))));
      },
    },
    ...parts,
    failed,
    h('div', { class: 'row end' }, send),
  );
}

function allFilled(fields: Field[]): boolean {
  const empty = fields.filter((one) => one.input.required && one.input.value === '');
  for (const one of fields) one.error(empty.includes(one) ? tShell('required') : null);
  empty[0]?.input.focus();
  return empty.length === 0;
}

function submitButton(text: string): HTMLButtonElement {
  return h('button', { type: 'submit', class: 'button primary large' }, text);
}

function passwordForm(): HTMLElement {
  const user = field(tShell('user'), 'user', { required: true, autocomplete: 'username', maxlength: 64 });
  const password = field(tShell('password'), 'password', { type: 'password', required: true, autocomplete: 'current-password', maxlength: 256 });
  const code = field(tShell('code'), 'totp', { inputmode: 'numeric', autocomplete: 'one-time-code', maxlength: 8 });
  const fields = [user, password, code];
  return form(fields.map((one) => one.root), submitButton(tShell('login')), fields, () =>
    login({ user: user.value, password: password.input.value, ...(code.value ? { totp: code.value } : {}) }),
  );
}

function pinForm(): HTMLElement {
  const user = field(tShell('user'), 'user', { required: true, autocomplete: 'username', maxlength: 64 });
  const pin = field(tShell('pin'), 'pin', { type: 'password', required: true, inputmode: 'numeric', maxlength: kLongestPin, hint: tShell('pin_hint') });
  const press = (digit: string) => () => {
    if (pin.input.value.length < kLongestPin) pin.input.value += digit;
  };
  const digits = ['1', '2', '3', '4', '5', '6', '7', '8', '9'].map((digit) => button(digit, press(digit)));
  const erase = button('⌫', () => void (pin.input.value = pin.input.value.slice(0, -1)), { label: tShell('delete_digit') });
  const pad = h('div', { class: 'pin-pad', role: 'group', 'aria-label': tShell('pin') }, ...digits, erase, button('0', press('0')));
  return form([h('div', { class: 'columns' }, h('div', { class: 'stack' }, user.root, pin.root), pad)], submitButton(tShell('login')), [user, pin], async () => {
    const value = pin.input.value;
    pin.input.value = '';
    await login({ user: user.value, pin: value });
  });
}

function setupForm(): HTMLElement {
  const user = field(tShell('user'), 'user', { required: true, autocomplete: 'username', maxlength: 64 });
  const look = { type: 'password', required: true, autocomplete: 'new-password', maxlength: 256 };
  const password = field(tShell('password'), 'password', { ...look, hint: tShell('password_rule') });
  const again = field(tShell('password_again'), 'again', look);
  const intro = h('p', null, tShell('setup_explain'));
  return form([intro, user.root, password.root, again.root], submitButton(tShell('setup_button')), [user, password, again], async () => {
    if (password.input.value.length < kLeastPassword) return password.error(tShell('password_rule'));
    if (password.input.value !== again.input.value) return again.error(tShell('passwords_differ'));
    await makeFirstAccount(user.value, password.input.value);
  });
}
