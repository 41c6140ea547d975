// Where an operator begins: a new visit, or one of the latest scans.
import { get } from '../../core/api';
import { h, replace } from '../../core/dom';
import { dateTime } from '../../core/format';
import type { Page } from '../../core/page';
import { navigate } from '../../core/router';
import { button, failurePanel, linkButton } from '../../core/ui';
import { booth, moves } from '../../core/booth';
import { tOperator as t } from '../../words/operator';
import { faultPanel, isFault } from './fault_panel';
import type { Scan } from './records';
import { profileName, verdictName } from './names';
import { dropVisit, visit } from './visit';

const kLatest = 8;

export const startPage: Page = {
  path: '/visit',
  roles: ['operator'],
  title: () => t('nav_visit'),
  mount(root) {
    const state = h('div', null);
    const latest = h('div', { class: 'stack' });
    const begin = () => {
      dropVisit();
      navigate('/visit/customer');
    };
    const goOn = visit.value.customer;
    replace(
      root,
      h(
        'div',
        { class: 'stack start' },
        h('h1', null, t('start_title')),
        h('p', { class: 'lead' }, t('start_text')),
        h(
          'div',
          { class: 'row' },
          button(t('start_button'), begin, { kind: 'primary', large: true }),
          goOn ? linkButton(t('start_go_on', { name: goOn.name }), '/visit/customer', { large: true }) : null,
        ),
        state,
        latest,
      ),
    );
    void showLatest(latest);
    let shown = '';
    return booth.watch((view) => {
      const key = JSON.stringify([isFault(view), view.status?.causes, view.status?.held_by, moves(view)]);
      if (key === shown) return;
      shown = key;
      replace(state, isFault(view) ? faultPanel(view) : moves(view) ? h('p', { class: 'note row spread' }, t('start_running'), linkButton(t('start_running_go'), '/visit/scan')) : null);
    });
  },
};

async function showLatest(root: HTMLElement): Promise<void> {
  try {
    const { scans } = await get<{ scans: Scan[] }>(`/api/scans?limit=${kLatest}`);
    const row = (scan: Scan) =>
      h('li', null, h('a', { class: 'card line', href: `#/scans/${scan.id}` }, h('strong', null, dateTime(scan.taken_ms)), h('span', null, profileName(scan.profile)), h('span', { class: 'muted' }, verdictName(scan.verdict))));
    if (scans.length > 0) replace(root, h('h2', null, t('start_latest')), h('ul', { class: 'lines' }, ...scans.map(row)));
  } catch (error) {
    replace(root, failurePanel(error));
  }
}
