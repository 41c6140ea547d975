// All that the station knows of a customer: change, withdraw, export, erase.
import { get, getBinary, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { bytes, date, dateTime } from '../../core/format';
import { dialog, toast } from '../../core/overlay';
import type { Page } from '../../core/page';
import { navigate } from '../../core/router';
import { button, failurePanel, linkButton, runBusy, showAtField, showFailure } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { customerFields, readCustomer } from './customer';
import { saveBlob } from './handover';
import { profileName, verdictName } from './names';
import { prescriptionForm } from './prescription';
import type { Consent, CustomerRecord, ErasureProof, Purpose, Scan } from './records';
import { changeVisit, dropVisit, visit } from './visit';

const purposeWords = { measure: 'purpose_measure', glasses: 'purpose_glasses', reshape: 'purpose_reshape', research: 'purpose_research' } as const;

export const recordPage: Page = {
  path: '/customers/:customer',
  roles: ['operator'],
  title: null,
  mount(root, parameters) {
    const id = parameters['customer'] ?? '';
    let gone = false;
    const open = async () => {
      try {
        const record = await get<CustomerRecord>(`/api/customers/${encodeURIComponent(id)}`);
        if (!gone) show(root, record, () => void open());
      } catch (error) {
        if (!gone) replace(root, failurePanel(error, () => void open()));
      }
    };
    void open();
    return () => {
      gone = true;
    };
  },
};

function show(root: HTMLElement, record: CustomerRecord, again: () => void): void {
  const take = button(t('customer_take'), () => (changeVisit({ customer: record, consent: null, scan: null }), navigate('/visit/consent')), { kind: 'primary', large: true });
  replace(
    root,
    h(
      'div',
      { class: 'stack' },
      h('div', { class: 'row spread' }, h('h1', null, record.name), take),
      h('p', { class: 'muted' }, t('record_keep', { since: date(record.created_ms), until: date(record.keep_until_ms) })),
      changeForm(record, again),
      h('h2', null, t('record_visits')),
      record.visits.length === 0 ? h('p', { class: 'muted' }, t('customer_no_scans')) : h('ul', { class: 'lines' }, ...record.visits.map(visitLine)),
      h('h2', null, t('record_consents')),
      record.consents.length === 0 ? h('p', { class: 'muted' }, t('record_no_consents')) : h('ul', { class: 'lines' }, ...record.consents.map((consent) => consentLine(consent, again))),
      h('h2', null, t('record_rights')),
      h('p', null, t('record_rights_text')),
      h('div', { class: 'row' }, button(t('record_export'), () => exportAll(record)), button(t('record_erase'), () => erase(root, record), { kind: 'danger' }), linkButton(t('back'), '/visit/customer', { kind: 'quiet' })),
    ),
  );
}

function changeForm(record: CustomerRecord, again: () => void): HTMLElement {
  const fields = customerFields(record);
  const prescription = prescriptionForm(record.prescription);
  const save = h('button', { type: 'submit', class: 'button' }, t('record_save'));
  const send = async () => {
    const body = readCustomer(fields);
    const written = prescription.read();
    if (!body || written === 'bad') return;
    try {
      await post(`/api/customers/${encodeURIComponent(record.id)}`, { ...body, ...(written ? { prescription: written } : {}) });
      toast(t('record_saved'), 'good');
      again();
    } catch (error) {
      if (!showAtField(error, fields.all)) showFailure(error);
    }
  };
  return h(
    'form',
    { class: 'card stack', novalidate: true, onsubmit: (event: Event) => (event.preventDefault(), void runBusy(save, send)) },
    h('div', { class: 'columns' }, h('div', { class: 'stack' }, fields.name.root, fields.contact.root, fields.height.root), fields.note.root),
    prescription.root,
    h('div', { class: 'row end' }, save),
  );
}

function visitLine(scan: Scan): HTMLElement {
  return h('li', null, h('a', { class: 'card line', href: `#/scans/${encodeURIComponent(scan.id)}` }, h('strong', null, dateTime(scan.taken_ms)), h('span', null, profileName(scan.profile)), h('span', { class: 'muted' }, scan.recording_missing ? t('record_missing') : verdictName(scan.verdict))));
}

function consentLine(consent: Consent, again: () => void): HTMLElement {
  const purposes = consent.purposes.map((purpose: Purpose) => t(purposeWords[purpose])).join(' · ');
  const withdraw = async () => {
    const answer = await dialog(t('withdraw_title'), [h('p', null, t('withdraw_text'))], [
      { answer: 'no', text: t('cancel') },
      { answer: 'yes', text: t('withdraw'), kind: 'danger' },
    ]);
    if (answer !== 'yes') return;
    await post(`/api/consents/${encodeURIComponent(consent.id)}/withdraw`);
    again();
  };
  const state = consent.withdrawn_ms === null ? h('span', { class: 'row end' }, button(t('withdraw'), withdraw)) : h('span', { class: 'badge warn' }, t('withdrawn', { date: date(consent.withdrawn_ms) }));
  return h('li', { class: 'card line' }, h('strong', null, dateTime(consent.given_ms)), h('span', null, purposes), state);
}

async function exportAll(record: CustomerRecord): Promise<void> {
  const answer = await getBinary(`/api/customers/${encodeURIComponent(record.id)}/export`);
  saveBlob(await answer.blob(), `${record.id}.zip`);
}

/** Asked for twice: what is erased cannot be brought back by anybody. */
async function erase(root: HTMLElement, record: CustomerRecord): Promise<void> {
  const answer = await dialog(t('erase_title', { name: record.name }), [h('p', null, t('erase_text'))], [
    { answer: 'no', text: t('cancel'), kind: 'primary' },
    { answer: 'yes', text: t('erase_yes'), kind: 'danger' },
  ]);
  if (answer !== 'yes') return;
  const proof = await post<ErasureProof>(`/api/customers/${encodeURIComponent(record.id)}/erase`, { confirm: record.id });
  if (visit.value.customer?.id === record.id) dropVisit();
  replace(root, proofPanel(proof));
}

function proofPanel(proof: ErasureProof): HTMLElement {
  const fine = proof.key_destroyed && proof.marker_hits === 0;
  return h(
    'div',
    { class: 'stack' },
    h('h1', null, t('erased_title')),
    h('div', { class: `note ${fine ? 'good' : 'bad'}`, role: 'status' }, h('p', null, t(fine ? 'erased_text' : 'erased_bad')), h('p', null, t('erased_proof', { rows: proof.rows, files: proof.files, bytes: bytes(proof.bytes_searched), hits: proof.marker_hits }))),
    h('div', null, linkButton(t('start_title'), '/visit', { kind: 'primary', large: true })),
  );
}
