// Measuring by hand on the model: the surface cursor of paper 001, landmarks, and two visits compared.
import { h, replace } from '../../core/dom';
import type { Page } from '../../core/page';
import { button, failurePanel, tabs } from '../../core/ui';
import { tMeasure } from '../../words/measure';
import { boundsOf, type StationMesh } from '../../view3d/mesh_format';
import { Viewer } from '../../view3d/viewer';
import { MeasureApi } from './api';
import { compareTool } from './compare_tool';
import { distanceTool } from './distance_tool';
import { landmarkTool } from './landmark_tool';
import { levelTool } from './level_tool';
import { regionTool } from './region_tool';
import { slabTool } from './slab_tool';
import type { Bench, Tool } from './tool';
import { fillWindow } from '../glasses/fill_window';
import '../glasses/glasses.css';
import './measure.css';

export const measurePage: Pick<Page, 'mount'> = {
  mount(root, { scan = '' }) {
    let end = (): void => {};
    let left = false;
    const begin = async (): Promise<void> => {
      replace(root, h('p', { class: 'muted' }, tMeasure('loading')));
      try {
        const api = new MeasureApi(scan);
        const mesh = await api.mesh();
        if (!left) end = open(root, api, mesh);
      } catch (error) {
        if (!left) replace(root, failurePanel(error, () => void begin()));
      }
    };
    void begin();
    return () => {
      left = true;
      end();
    };
  },
};

function open(root: HTMLElement, api: MeasureApi, mesh: StationMesh): () => void {
  const pictures = h('div', { class: 'measure-pictures' });
  const first = h('section', { class: 'booth', 'aria-label': tMeasure('this_visit') });
  const second = h('section', { class: 'booth', 'aria-label': tMeasure('other_visit'), hidden: true });
  pictures.append(first, second);
  const toolbar = h('div', { class: 'toolbar', role: 'toolbar', 'aria-label': tMeasure('view') });
  const side = h('aside', { class: 'designer-side', 'aria-label': tMeasure('title') });
  const designer = h('div', { class: 'designer' },
    h('div', { class: 'designer-main' }, h('h1', { class: 'hidden-text', tabindex: -1 }, tMeasure('title')), toolbar, pictures), side);
  replace(root, designer);
  const offSize = fillWindow(designer);
  const viewer = new Viewer(first, { label: tMeasure('view_label'), unavailable: tMeasure('unavailable') });
  viewer.setMesh('body', mesh, { knowledge: true });
  viewer.frame();
  toolbar.append(
    button(tMeasure('front'), () => viewer.view('front')),
    button(tMeasure('from_left'), () => viewer.view('left45')),
    button(tMeasure('from_right'), () => viewer.view('right45')),
    button(tMeasure('back'), () => viewer.view('back')),
    button(tMeasure('frame_all'), () => viewer.frame(), { kind: 'quiet' }),
    h('span', { class: 'legend' }, tMeasure('legend')),
  );
  const bounds = boundsOf(mesh);
  const bench: Bench = { viewer, api, low_mm: bounds?.low[2] ?? 0, high_mm: bounds?.high[2] ?? 0 };
  const current = chooseTools(bench, second, side);
  return () => {
    offSize();
    current()?.end();
    viewer.dispose();
  };
}

/** Tabs of tools, of which one is open; what is returned says which. */
function chooseTools(bench: Bench, second: HTMLElement, side: HTMLElement): () => Tool | null {
  const makers = {
    distance: () => distanceTool(bench),
    level: () => levelTool(bench),
    slab: () => slabTool(bench),
    region: () => regionTool(bench),
    landmarks: () => landmarkTool(bench),
    compare: () => compareTool(bench, second),
  };
  const made = new Map<string, Tool>();
  let now: Tool | null = null;
  const list = (Object.keys(makers) as (keyof typeof makers)[]).map((key) => ({
    label: tMeasure(key),
    panel: () => {
      now?.end();
      const tool = made.get(key) ?? makers[key]();
      made.set(key, tool);
      now = tool;
      tool.begin();
      return tool.root;
    },
  }));
  side.append(tabs(tMeasure('title'), list));
  return () => now;
}
