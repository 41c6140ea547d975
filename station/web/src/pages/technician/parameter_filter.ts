// Values of the configuration, and which of them somebody looks for.

export interface ConfigKey {
  key: string;
  value: unknown;
  source: string;
  line?: number | null;
}

export interface Parameters {
  path: string;
  text: string;
  sections: { name: string; values: ConfigKey[] }[];
}

/** Sections with the values that hold every word that was typed. */
export function matchingKeys(sections: Parameters['sections'], typed: string): Parameters['sections'] {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  return sections
    .map(({ name, values }) => ({ name, values: values.filter((one) => words.every((word) => `[${name}] ${one.key} ${valueText(one.value)}`.toLowerCase().includes(word))) }))
    .filter((section) => section.values.length > 0);
}

export function valueText(value: unknown): string {
  return typeof value === 'string' ? value : JSON.stringify(value);
}
