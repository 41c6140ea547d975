// What a fit says of itself, for two of them side by side.

/** As `annulus fit --report`, with the picture of its residuals. */
export interface FitReport {
  model_id: string;
  residuals_png?: string;
  time_s?: Record<string, number>;
  coefficients?: number;
  rms_mm?: number;
  noise_sigma_mm?: number;
  detail_sigma_mm?: number;
  effective_parameters?: number;
  rejected?: unknown[] | number;
  segments?: unknown[] | number;
}

export interface FitOptions {
  method: string;
  theta_knots?: number;
  z_knots?: number;
}

/** Knots are the uniform method's alone; empty or 0 is its own choice. */
export function optionsOf(method: string, thetaKnots: string, zKnots: string): FitOptions {
  const options: FitOptions = { method };
  if (method !== 'uniform') return options;
  if (Number(thetaKnots) > 0) options.theta_knots = Number(thetaKnots);
  if (Number(zKnots) > 0) options.z_knots = Number(zKnots);
  return options;
}

export interface FitRow {
  key: string;
  /** A stage's own name. */
  name?: string;
  a: number | null;
  b: number | null;
}

const plainRows = ['rms_mm', 'noise_sigma_mm', 'detail_sigma_mm', 'coefficients', 'effective_parameters', 'rejected', 'segments'] as const;

/** The numbers of both, and the time of every stage that one of them has. */
export function fitRows(a: FitReport | null, b: FitReport | null): FitRow[] {
  const value = (report: FitReport | null, key: (typeof plainRows)[number]): number | null => {
    const one = report?.[key];
    if (Array.isArray(one)) return one.length;
    return typeof one === 'number' ? one : null;
  };
  const rows: FitRow[] = plainRows.map((key) => ({ key, a: value(a, key), b: value(b, key) }));
  const stages = [...new Set([...Object.keys(a?.time_s ?? {}), ...Object.keys(b?.time_s ?? {})])];
  for (const stage of stages) rows.push({ key: 'time_s', name: `${stage}, s`, a: a?.time_s?.[stage] ?? null, b: b?.time_s?.[stage] ?? null });
  return rows.filter((row) => row.a !== null || row.b !== null);
}

/** The picture as an address: it comes as base64. */
export function pictureSource(report: FitReport): string | null {
  const picture = report.residuals_png;
  if (!picture) return null;
  if (picture.startsWith('data:') || picture.startsWith('/')) return picture;
  return `data:image/png;base64,${picture}`;
}
