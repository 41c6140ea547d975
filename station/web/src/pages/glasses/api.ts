// The designer's requests (docs/console_api.md §9), typed.
import { get, getBinary, post, postForBinary } from '../../core/api';
import { readMesh, type StationMesh } from '../../view3d/mesh_format';
import type { SolidPlace, SolidTexture } from '../../view3d/solid_texture';
import type { Rgb } from './colour';
import { designBody, lookBody, type Design } from './design';
import type { Job } from './jobs';
import type { Prescription } from './prescription';

export interface Size {
  id: string;
  /** As on the temple: "52□18-140". */
  marking: string;
  a_mm: number;
  b_mm: number | null;
  dbl_mm: number;
  temple_mm: number;
}

/** Values of a frame's fields by their options ("upper-outer"): in the field's unit, a word, or null: as the paper has it. */
export type FieldValues = Record<string, number | string | null>;

export interface Style {
  id: string;
  name: string;
  material: string;
  sizes: Size[];
  values: FieldValues;
}

/** A field of a frame that is chosen by number; `words` instead of a range: by word. */
export interface FrameField {
  /** Option of a design's `fields`: "upper-outer". */
  id: string;
  label: string;
  unit: string;
  low?: number;
  high?: number;
  step?: number;
  low_word?: string;
  high_word?: string;
  words?: string[];
}

export interface Catalogue {
  styles: Style[];
  /** The eight of paper 000, fig. 22. */
  sliders: FrameField[];
  details?: FrameField[];
  textures: string[];
  finishes: string[];
  coatings: string[];
  colours: Rgb[];
  lights: string[];
}

/** What the preview says about the frame that it shows. */
export interface PreviewNotes {
  /** What was changed so that it can be built, one sentence each. */
  adjusted: string[];
  placement?: string;
  placement_text?: string;
  values?: FieldValues;
  /** Marking: "52□18-140". */
  size?: string;
  /** Of the first two parts of the mesh; they lie in the frame's own coordinates. */
  textures?: { frame_from_station: SolidPlace; upper: SolidTexture; lower: SolidTexture };
}

export interface Goal {
  id: string;
  term: string;
  unit: string;
  value: number;
  sigma?: number;
  low: number;
  high: number;
  met: boolean;
  advice?: string;
}

export interface Contact {
  part: string;
  distance_mm: number;
  load_share: number;
  pressure_kpa: number;
}

/** As `annulus glasses fit --json`. */
export interface FitReport {
  wearable: boolean;
  score: number;
  advice: string[];
  goals: Goal[];
  contacts: Contact[];
  penetration_mm: number;
  balance: { frame_g: number; lenses_g: number; nose_share: number; right_share: number };
}

export interface Artefact {
  id: string;
  kind: string;
  name: string;
}

export interface RankedFrame {
  rank: number;
  style: string;
  size: string;
  marking: string;
  score: number;
  /** "fits", or the first advice. */
  why: string;
  goals?: Goal[];
  design: object;
}

export interface SavedDesign {
  id: string;
  title: string;
  design: { style: string; size?: string; fields?: Record<string, number | string> };
  look: object;
  prescription: Prescription | null;
  made_ms: number;
}

export interface Hvc {
  hue: number;
  value: number;
  chroma: number;
}

export interface PictureOrder {
  worn?: string;
  view: string;
  size: number;
  samples: number;
  light?: string;
}

/** The requests for one scan. */
export class GlassesApi {
  readonly #scan: string;

  constructor(scan: string) {
    this.#scan = `/api/scans/${encodeURIComponent(scan)}`;
  }

  catalogue(): Promise<Catalogue> {
    return get('/api/glasses/catalogue');
  }

  /** The head, coarse enough that it and a frame (≤ 20,000) are ≤ 40,000 triangles. */
  async head(): Promise<StationMesh> {
    return readMesh(await (await getBinary(`${this.#scan}/mesh?triangles=20000`)).arrayBuffer());
  }

  /** Frame and lenses where they sit, and what was adjusted so that they can be built. */
  async preview(design: Design): Promise<{ mesh: StationMesh; notes: PreviewNotes }> {
    const body = { design: designBody(design), look: lookBody(design.look), placement: 'quick' };
    const response = await postForBinary(`${this.#scan}/glasses/preview`, body);
    return { mesh: readMesh(await response.arrayBuffer()), notes: notesOf(response.headers.get('X-Annulus-Notes')) };
  }

  fit(design: Design, prescription: Prescription | null): Promise<Job> {
    return post(`${this.#scan}/glasses/fit`, { design: designBody(design), ...(prescription && { prescription }) });
  }

  rank(prescription: Prescription | null, top: number): Promise<Job> {
    return post(`${this.#scan}/glasses/rank`, { top, ...(prescription && { prescription }) });
  }

  /** The tracer's picture; of the worn frame if it is known, else of the design as it sits at once. */
  picture(design: Design, order: PictureOrder): Promise<Job> {
    const what = order.worn ? { worn: order.worn } : { design: designBody(design) };
    const { view, size, samples, light } = order;
    return post(`${this.#scan}/glasses/picture`, { ...what, look: lookBody(design.look), view, size, method: 'trace', samples, ...(light && { light }) });
  }

  designs(): Promise<{ designs: SavedDesign[] }> {
    return get(`${this.#scan}/designs`);
  }

  save(title: string, design: Design, prescription: Prescription | null): Promise<SavedDesign> {
    return post(`${this.#scan}/designs`, { title, design: designBody(design), look: lookBody(design.look), ...(prescription && { prescription }) });
  }

  update(id: string, title: string, design: Design): Promise<SavedDesign> {
    return post(`/api/designs/${encodeURIComponent(id)}`, { title, design: designBody(design), look: lookBody(design.look) });
  }

  remove(id: string): Promise<unknown> {
    return post(`/api/designs/${encodeURIComponent(id)}/remove`);
  }

  export(worn: string, format: 'stl' | 'step' | 'dcs' | 'json' | 'pdf', confirmed_by: string): Promise<Job> {
    return post(`${this.#scan}/glasses/export`, { worn, format, ...(confirmed_by && { confirmed_by }) });
  }

  /** The colour after a change of value and chroma, −1 … 1 each; of three requests the newest counts. */
  colour(rgb: Rgb, change: { value?: number; chroma?: number } = {}): Promise<{ rgb: Rgb; hvc: Hvc; clipped: boolean }> {
    return post('/api/colour', { rgb, ...(Object.keys(change).length > 0 && { change }) });
  }
}

/** What the header says; nothing if it is damaged: it is advice, nothing depends on it. */
export function notesOf(header: string | null): PreviewNotes {
  try {
    const notes = JSON.parse(header ?? '{}') as Partial<PreviewNotes> | string[] | null;
    if (Array.isArray(notes)) return { adjusted: notes.map(String) };
    return { ...notes, adjusted: Array.isArray(notes?.adjusted) ? notes.adjusted.map(String) : [] };
  } catch {
    return { adjusted: [] };
  }
}
