// The state of what is kept.
import { get } from '../../core/api';
import { h, replace } from '../../core/dom';
import { bytes } from '../../core/format';
import { on } from '../../core/live';
import type { Page } from '../../core/page';
import { failurePanel } from '../../core/ui';
import { tAdmin as t } from '../../words/admin';

interface StoreState {
  state: string;
  problem: string | null;
  customers: number;
  scans: number;
  bytes: number;
  schema: number;
}

export const storePage: Page = {
  path: '/admin/store',
  roles: ['admin'],
  title: () => t('nav_store'),
  mount(root) {
    const content = h('div', { class: 'stack' });
    let gone = false;
    const load = async () => {
      try {
        const store = await get<StoreState>('/api/store');
        if (!gone) replace(content, stateOf(store));
      } catch (error) {
        if (!gone) replace(content, failurePanel(error, () => void load()));
      }
    };
    void load();
    const end = on('store', () => void load());
    replace(root, h('div', { class: 'stack' }, h('h1', null, t('store_title')), content));
    return () => {
      gone = true;
      end();
    };
  },
};

function stateOf(store: StoreState): HTMLElement {
  const line = (name: string, value: string | number) => [h('dt', null, name), h('dd', { class: 'number' }, value)];
  const fine = !store.problem;
  return h(
    'div',
    { class: 'stack' },
    h('p', { class: `note ${fine ? 'good' : 'bad'}`, role: 'status' }, fine ? t('state_ok') : `${store.state}: ${store.problem ?? ''}`),
    h('dl', { class: 'card facts' }, ...line(t('customers'), store.customers), ...line(t('scans'), store.scans), ...line(t('size'), bytes(store.bytes)), ...line(t('schema'), store.schema)),
  );
}
