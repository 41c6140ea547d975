// The tracer's true pictures: they come coarse at once and get finer.
import { getBinary } from '../../core/api';
import { h, replace } from '../../core/dom';
import { button, choice, textOf } from '../../core/ui';
import { lightWord, tGlasses } from '../../words/glasses';
import type { Desk, Side } from './desk';
import { cancelJob, ended, followJob, type Job } from './jobs';
import type { Stage } from './stage';

const picturePixels = 640;
const picturePaths = 256;
const lookEvery_ms = 700;

/** Shows pictures over the stage; `end` stops everything. */
export function picturesOver(desk: Desk, stage: Stage): { root: HTMLElement; here(): void; three(): void; end(): void } {
  const strip = h('div', { class: 'picture-strip' });
  const light = choice(tGlasses('light'), 'light', desk.catalogue.lights.map((one) => [one, lightWord(one)] as const), desk.catalogue.lights[0] ?? '');
  let again = (): void => {};
  light.input.addEventListener('change', () => again());
  const running = new Set<() => void>();
  const stopAll = (): void => {
    for (const stop of running) stop();
    running.clear();
    replace(strip);
  };
  const close = (): void => {
    stopAll();
    root.hidden = true;
  };
  const root = h('section', { class: 'pictures', hidden: true, 'aria-label': tGlasses('picture') },
    h('div', { class: 'row' }, light.root, button(tGlasses('picture_close'), close)), strip);
  const order = (view: string, name: string): void => {
    root.hidden = false;
    for (const side of (desk.bench.value.b ? ['a', 'b'] : ['a']) as Side[]) {
      const stop = tracePicture(desk, side, view, name, light.input.value, strip);
      running.add(stop);
    }
  };
  return {
    root,
    here: () => {
      close();
      const place = stage.camera();
      if (!place) return;
      again = () => {
        stopAll();
        order(`${place.azimuth_deg.toFixed(1)},${place.elevation_deg.toFixed(1)}`, tGlasses('picture_here'));
      };
      again();
    },
    three: () => {
      close();
      again = () => {
        stopAll();
        for (const [view, name] of [['right45', tGlasses('from_right')], ['front', tGlasses('front')], ['left45', tGlasses('from_left')]] as const) order(view, name);
      };
      again();
    },
    end: close,
  };
}

/** One picture; what is returned gives it up. */
function tracePicture(desk: Desk, side: Side, view: string, name: string, light: string, strip: HTMLElement): () => void {
  const title = tGlasses('picture_of', { name: tGlasses(side === 'a' ? 'design_a' : 'design_b'), view: name });
  const image = h('img', { alt: title, width: picturePixels, height: picturePixels });
  const state = h('figcaption', null, `${title} · ${tGlasses('picture_waiting')}`);
  strip.append(h('figure', null, image, state));
  let job: Job | null = null;
  let over = false;
  let url = '';
  let unfollow = (): void => {};
  const show = async (path: string): Promise<void> => {
    const response = await getBinary(path);
    const blob = await response.blob();
    if (over) return;
    URL.revokeObjectURL(url);
    url = URL.createObjectURL(blob);
    image.src = url;
    const share = Number(response.headers.get('X-Annulus-Share') ?? 1);
    state.textContent = `${title} · ${share < 1 ? tGlasses('picture_running', { share: Math.round(100 * share) }) : tGlasses('picture_done')}`;
  };
  const look = async (): Promise<void> => {
    while (job && !over && !ended(job)) {
      // 404 until there is a first one.
      await show(`/api/jobs/${encodeURIComponent(job.id)}/picture`).catch(() => {});
      await new Promise((resolve) => setTimeout(resolve, lookEvery_ms));
    }
  };
  const failed = (error: unknown): void => void (state.textContent = `${title} · ${textOf(error).seen}. ${textOf(error).advice}`);
  const begin = async (): Promise<void> => {
    const bench = desk.bench.value;
    const worn = desk.fresh(side)?.worn;
    job = await desk.api.picture(side === 'b' && bench.b ? bench.b : bench.a, { view, size: picturePixels, samples: picturePaths, ...(worn && { worn }), ...(light && { light }) });
    unfollow = followJob(job, (next) => {
      job = next;
      const result = next.result as { picture?: { id: string } } | null;
      if (next.state === 'done' && result?.picture) void show(`/api/artefacts/${encodeURIComponent(result.picture.id)}`).catch(failed);
      if (next.state === 'failed' && next.error) state.textContent = `${title} · ${next.error.seen}. ${next.error.advice}`;
    });
    await look();
  };
  begin().catch(failed);
  return () => {
    over = true;
    unfollow();
    URL.revokeObjectURL(url);
    if (job && !ended(job)) void cancelJob(job.id).catch(() => {});
  };
}
