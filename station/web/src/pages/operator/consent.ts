// Step 2: what the customer agrees to, in the station's words.
import { get, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { date } from '../../core/format';
import type { Page } from '../../core/page';
import { navigate } from '../../core/router';
import { button, check, failurePanel } from '../../core/ui';
import { language } from '../../core/words';
import { tOperator as t } from '../../words/operator';
import { standingConsent, type Consent, type ConsentText, type CustomerRecord, type Purpose } from './records';
import { needs, stepFrame, type StepFrame } from './step_frame';
import { changeVisit, visit } from './visit';

/** Without it nothing may be measured. */
const kNeeded: Purpose = 'measure';

export const consentPage: Page = {
  path: '/visit/consent',
  roles: ['operator'],
  title: null,
  mount(root) {
    if (!needs('customer')) return () => {};
    const frame = stepFrame(root, { step: 'step_consent', title: t('consent_title'), back: '/visit/customer' });
    void show(frame);
    return frame.end;
  },
};

async function show(frame: StepFrame): Promise<void> {
  const customer = visit.value.customer;
  if (!customer) return;
  try {
    const [text, record] = await Promise.all([
      get<ConsentText>(`/api/consent-text?language=${language.value}`),
      get<CustomerRecord>(`/api/customers/${encodeURIComponent(customer.id)}`),
    ]);
    const standing = standingConsent(record.consents, kNeeded);
    const old = standing && standing.text_version === text.version ? standing : null;
    replace(frame.content, old ? oldConsent(old, text) : null, consentForm(frame, customer.id, text, old !== null));
  } catch (error) {
    replace(frame.content, failurePanel(error, () => void show(frame)));
  }
}

function use(consent: Consent): void {
  changeVisit({ consent });
  navigate('/visit/checks');
}

function oldConsent(consent: Consent, text: ConsentText): HTMLElement {
  const agreed = text.purposes.filter((purpose) => consent.purposes.includes(purpose.id)).map((purpose) => purpose.text);
  return h(
    'div',
    { class: 'note good row spread' },
    h('div', null, h('strong', null, t('consent_standing', { date: date(consent.given_ms) })), h('br'), agreed.join(language.value === 'ja' ? '、' : '; ')),
    button(t('consent_use'), () => use(consent), { kind: 'primary', large: true }),
  );
}

function consentForm(frame: StepFrame, customerId: string, text: ConsentText, haveOld: boolean): HTMLElement {
  const chosen = new Set<Purpose>([kNeeded]);
  const agreed = check(t('consent_agreed'), false, () => allow());
  const sign = button(
    t('consent_sign'),
    async () => {
      const body = { purposes: text.purposes.map((purpose) => purpose.id).filter((id) => chosen.has(id)), text_version: text.version, language: text.language, agreed: true };
      use(await post<Consent>(`/api/customers/${encodeURIComponent(customerId)}/consents`, body));
    },
    { kind: haveOld ? 'plain' : 'primary', large: true, disabled: true },
  );
  const allow = () => {
    sign.disabled = !agreed.input.checked || !chosen.has(kNeeded);
  };
  const purpose = (one: { id: Purpose; text: string }) => {
    const box = check(one.id === kNeeded ? `${one.text} ${t('consent_needed')}` : one.text, chosen.has(one.id), (yes) => {
      if (yes) chosen.add(one.id);
      else chosen.delete(one.id);
      allow();
    });
    box.input.disabled = one.id === kNeeded;
    return box.root;
  };
  replace(frame.actions, sign);
  return h(
    'div',
    { class: 'card stack' },
    h('div', { lang: text.language, class: 'consent-text', tabindex: 0, role: 'region', 'aria-label': text.title }, h('h2', null, text.title), ...text.paragraphs.map((paragraph) => h('p', null, paragraph))),
    h('fieldset', { class: 'purposes' }, h('legend', null, t('consent_purposes')), ...text.purposes.map(purpose)),
    agreed.root,
  );
}
