// Step 1: who is it? Find somebody, or write somebody down.
import { get, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { date } from '../../core/format';
import type { Page } from '../../core/page';
import { navigate } from '../../core/router';
import { button, failurePanel, field, runBusy, showAtField, showFailure, tabs, type Field } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { prescriptionForm } from './prescription';
import type { Customer } from './records';
import { stepFrame } from './step_frame';
import { changeVisit } from './visit';

const kSearchAfter_ms = 200;
const kMostFound = 12;
/** What the booth takes as a height, cm. */
export const heightRange_cm = { min: 30, max: 250 };

export const customerPage: Page = {
  path: '/visit/customer',
  roles: ['operator'],
  title: null,
  mount(root) {
    const frame = stepFrame(root, { step: 'step_customer', title: t('customer_title'), back: '/visit' });
    replace(
      frame.content,
      tabs(t('customer_title'), [
        { label: t('customer_find'), panel: findPanel },
        { label: t('customer_new'), panel: newPanel },
      ]),
    );
    return frame.end;
  },
};

function choose(customer: Customer): void {
  changeVisit({ customer, consent: null, scan: null });
  navigate('/visit/consent');
}

function findPanel(): HTMLElement {
  const search = field(t('customer_search'), 'search', { type: 'search', hint: t('customer_search_hint') });
  const found = h('ul', { class: 'lines', 'aria-live': 'polite' });
  let asked = 0;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const look = async () => {
    asked += 1;
    const mine = asked;
    try {
      const { customers } = await get<{ customers: Customer[] }>(`/api/customers?search=${encodeURIComponent(search.value)}&limit=${kMostFound}`);
      if (mine === asked) replace(found, ...(customers.length > 0 ? customers.map(line) : [h('li', { class: 'muted' }, t('customer_none'))]));
    } catch (error) {
      if (mine === asked) replace(found, h('li', null, failurePanel(error, () => void look())));
    }
  };
  search.input.addEventListener('input', () => {
    clearTimeout(timer);
    timer = setTimeout(() => void look(), kSearchAfter_ms);
  });
  void look();
  return h('div', { class: 'stack' }, search.root, found);
}

function line(customer: Customer): HTMLElement {
  return h(
    'li',
    { class: 'card line' },
    h('strong', null, customer.name),
    h('span', { class: 'muted' }, customer.scans > 0 ? t('customer_scans', { n: customer.scans }) : t('customer_no_scans')),
    h('span', { class: 'muted' }, t('customer_since', { date: date(customer.created_ms) })),
    h(
      'span',
      { class: 'row end' },
      h('a', { class: 'button quiet', href: `#/customers/${encodeURIComponent(customer.id)}`, 'aria-label': `${t('customer_record')}: ${customer.name}` }, t('customer_record')),
      button(t('customer_take'), () => choose(customer), { kind: 'primary', label: `${t('customer_take')}: ${customer.name}` }),
    ),
  );
}

/** The fields of a customer; also used to change one. */
export function customerFields(customer: Partial<Customer> = {}) {
  const name = field(t('customer_name'), 'name', { required: true, maxlength: 120, value: customer.name ?? '' });
  const contact = field(t('customer_contact'), 'contact', { maxlength: 200, value: customer.contact ?? '' });
  const height = field(t('customer_height'), 'height_mm', {
    type: 'number',
    ...heightRange_cm,
    step: 0.1,
    inputmode: 'decimal',
    hint: t('customer_height_hint'),
    value: customer.height_mm ? String(customer.height_mm / 10) : '',
  });
  const note = field(t('customer_note'), 'note', { lines: 3, maxlength: 2000, hint: t('customer_note_hint'), value: customer.note ?? '' });
  return { name, contact, height, note, all: [name, contact, height, note] };
}

/** What is wrong with them is shown at them; then null. */
export function readCustomer(fields: ReturnType<typeof customerFields>): Partial<Customer> | null {
  const height_cm = fields.height.value === '' ? null : Number(fields.height.value);
  const badHeight = height_cm !== null && !(height_cm >= heightRange_cm.min && height_cm <= heightRange_cm.max);
  setErrors([
    [fields.name, fields.name.value === '' ? t('customer_name_needed') : null],
    [fields.height, badHeight || !fields.height.input.checkValidity() ? t('customer_height_bad', heightRange_cm) : null],
  ]);
  const bad = fields.all.find((one) => one.input.getAttribute('aria-invalid') === 'true');
  bad?.input.focus();
  if (bad) return null;
  return { name: fields.name.value, contact: fields.contact.value, note: fields.note.value, ...(height_cm === null ? {} : { height_mm: Math.round(height_cm * 10) }) };
}

function setErrors(errors: [Field, string | null][]): void {
  for (const [one, text] of errors) one.error(text);
}

function newPanel(): HTMLElement {
  const fields = customerFields();
  const prescription = prescriptionForm(null);
  const save = h('button', { type: 'submit', class: 'button primary large' }, t('customer_save'));
  const send = async () => {
    const body = readCustomer(fields);
    const written = prescription.read();
    if (!body || written === 'bad') return;
    try {
      choose(await post<Customer>('/api/customers', { ...body, ...(written ? { prescription: written } : {}) }));
    } catch (error) {
      if (!showAtField(error, fields.all)) showFailure(error);
    }
  };
  return h(
    'form',
    { class: 'stack', novalidate: true, onsubmit: (event: Event) => (event.preventDefault(), void runBusy(save, send)) },
    h('div', { class: 'columns' }, h('div', { class: 'stack' }, fields.name.root, fields.contact.root, fields.height.root), fields.note.root),
    prescription.root,
    h('div', { class: 'row end' }, save),
  );
}
