// What the station keeps of customers and scans (docs/console_api.md §3, §7).

export type Purpose = 'measure' | 'glasses' | 'reshape' | 'research';

export interface Consent {
  id: string;
  purposes: Purpose[];
  text_version: string;
  language: string;
  given_ms: number;
  withdrawn_ms: number | null;
}

export interface Customer {
  id: string;
  name: string;
  contact: string;
  note: string;
  height_mm: number | null;
  prescription: object | null;
  created_ms: number;
  keep_until_ms: number;
  scans: number;
}

export interface CustomerRecord extends Customer {
  consents: Consent[];
  visits: Scan[];
}

export interface ConsentText {
  version: string;
  language: string;
  title: string;
  paragraphs: string[];
  purposes: { id: Purpose; text: string }[];
}

export type Verdict = 'good' | 'usable' | 'repeat' | '';

export interface Scan {
  id: string;
  customer_id: string;
  consent_id: string;
  profile: string;
  taken_ms: number;
  verdict: Verdict;
  recording_missing: boolean;
  model: boolean;
  summary: {
    levels: number;
    planned_levels: number;
    coverage: number;
    notices: { code: string; text: string; advice: string }[];
    released: boolean;
  } | null;
}

/** What was agreed to, is not withdrawn, and allows what is wanted. */
export function standingConsent(consents: readonly Consent[], wanted: Purpose): Consent | null {
  const standing = consents.filter((consent) => consent.withdrawn_ms === null && consent.purposes.includes(wanted));
  return standing.sort((a, b) => b.given_ms - a.given_ms)[0] ?? null;
}

/** Proof that somebody's data are gone. */
export interface ErasureProof {
  customer_id: string;
  files: number;
  rows: number;
  key_destroyed: boolean;
  bytes_searched: number;
  marker_hits: number;
}
