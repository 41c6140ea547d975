// The frame around every page, and which page is in it.
import { booth, lampOf } from './booth';
import { h, replace } from './dom';
import { connected } from './live';
import { chooseLanguage, shownTheme, switchTheme, theme } from './look';
import { closeDialog, dialog } from './overlay';
import { findPage, firstPath, mayOpen, navigate, pathOf, type PageEntry, type Place } from './router';
import { logout, role, secondsLeft, session, stayLoggedIn } from './session';
import { stopButton } from './stop';
import { button, failurePanel, linkButton } from './ui';
import { language } from './words';
import { tShell } from '../words/shell';

let leave: () => void = () => {};
let turn = 0;

/** Builds the frame in `app` and follows address, session and language. Called once. */
export function startShell(app: HTMLElement, entries: readonly PageEntry[], login: PageEntry): void {
  const main = h('main', { id: 'main', tabindex: -1 });
  const navigation = h('nav', { class: 'navigation' });
  const banners = h('div', { 'aria-live': 'polite' });
  replace(app, h('a', { class: 'hidden-text', href: '#main', onclick: skipTo(main) }, tShell('skip')), header(), navigation, banners, main);

  const show = () => {
    drawNavigation(navigation, entries);
    void open(main, entries, login);
  };
  addEventListener('hashchange', show);
  let shown = '';
  const showIfOther = () => {
    const key = `${session.value?.user ?? ''}|${role()}|${language.value}|${session.value === null}`;
    if (key === shown) return;
    shown = key;
    closeDialog();
    show();
  };
  session.watch(showIfOther);
  language.watch(showIfOther);
  watchBanners(banners);
  watchTimeout();
}

function skipTo(main: HTMLElement) {
  return (event: Event) => {
    event.preventDefault();
    main.focus();
  };
}

/** Puts the page of the present address into `main`, or the login, or why not. */
async function open(main: HTMLElement, entries: readonly PageEntry[], login: PageEntry): Promise<void> {
  turn += 1;
  const mine = turn;
  leave();
  leave = () => {};
  if (!session.value) return replace(main, h('p', { class: 'page muted' }, tShell('loading')));
  const place = role() === 'none' ? { entry: login, parameters: {} } : wanted(entries);
  if (!place) return replace(main, notHere(tShell('not_found'), ''));
  if (role() !== 'none' && !mayOpen(place.entry, role())) return replace(main, notHere(tShell('forbidden'), tShell('forbidden_do')));
  const root = h('div', { class: 'page' });
  try {
    const page = await place.entry.load();
    if (mine !== turn) return;
    replace(main, root);
    const unmount = page.mount(root, place.parameters);
    scrollTo(0, 0);
    const endFocus = focusHeading(root);
    leave = () => {
      endFocus();
      unmount();
    };
  } catch (error) {
    if (mine === turn) replace(main, h('div', { class: 'page' }, failurePanel(error, () => location.reload())));
  }
}

function wanted(entries: readonly PageEntry[]): Place | null {
  const path = pathOf(location.hash);
  return findPage(entries, path === '/' ? (firstPath(entries, role()) ?? '/') : path);
}

/** So that a screen reader begins with the new page, and Tab goes on from there; some pages come after an answer. */
function focusHeading(root: HTMLElement): () => void {
  const take = (): boolean => {
    const heading = root.querySelector('h1');
    if (!heading) return false;
    document.title = `${heading.textContent} · annulus`;
    if (root.contains(document.activeElement)) return true;
    heading.tabIndex = -1;
    heading.focus({ preventScroll: true });
    return true;
  };
  document.title = 'annulus';
  if (take()) return () => {};
  const later = new MutationObserver(() => take() && later.disconnect());
  later.observe(root, { childList: true, subtree: true });
  return () => later.disconnect();
}

function notHere(title: string, advice: string): HTMLElement {
  return h('div', { class: 'page stack' }, h('h1', null, title), h('p', null, advice), h('p', null, linkButton(tShell('home'), '/')));
}

/** In our own words: the page's language need not be the station's. */
const stateWords = {
  SAFE: 'state_SAFE',
  IDLE: 'state_IDLE',
  HOMING: 'state_HOMING',
  ARMED: 'state_ARMED',
  SCANNING: 'state_SCANNING',
  STOPPING: 'state_STOPPING',
  FAULT: 'state_FAULT',
  JOG: 'state_JOG',
} as const;

function header(): HTMLElement {
  const state = h('div', { class: 'booth-state', role: 'status' });
  const tools = h('div', { class: 'tools' });
  const drawState = () => {
    const view = booth.value;
    state.dataset['lamp'] = lampOf(view);
    const text = view.connected && view.status ? tShell(stateWords[view.status.state]) : tShell('booth_away');
    replace(state, h('span', { class: 'lamp', 'aria-hidden': 'true' }), h('span', null, text), session.value?.simulated ? h('span', { class: 'badge warn' }, tShell('simulated')) : null);
  };
  const drawTools = () => {
    const other = language.value === 'en' ? 'ja' : 'en';
    const languageButton = button(tShell('language'), () => chooseLanguage(other), { kind: 'quiet' });
    languageButton.lang = other;
    languageButton.title = tShell('language_label');
    const themeButton = button(shownTheme() === 'dark' ? '☀' : '☾', switchTheme, { kind: 'quiet', label: shownTheme() === 'dark' ? tShell('light') : tShell('dark') });
    const user = session.value?.user;
    replace(tools, languageButton, themeButton, user ? h('span', { class: 'user', title: user }, user) : null, user ? button(tShell('logout'), logOut, { kind: 'quiet' }) : null);
  };
  const drawBoth = () => {
    drawState();
    drawTools();
  };
  booth.watch(drawState);
  session.watch(drawBoth);
  language.watch(drawBoth);
  theme.watch(drawTools);
  const brand = h('a', { class: 'brand', href: '#/', 'aria-label': 'annulus' }, h('img', { src: '/icon.svg', alt: '' }), h('span', null, 'annulus'));
  return h('header', { class: 'header' }, brand, state, tools, stopButton());
}

async function logOut(): Promise<void> {
  await logout();
  navigate('/');
}

function drawNavigation(navigation: HTMLElement, entries: readonly PageEntry[]): void {
  const path = pathOf(location.hash);
  const here = findPage(entries, path === '/' ? (firstPath(entries, role()) ?? '/') : path)?.entry;
  const links = entries
    .filter((entry) => entry.title !== null && mayOpen(entry, role()))
    .map((entry) => h('li', null, h('a', { href: `#${entry.path}`, 'aria-current': entry === here ? 'page' : null }, entry.title?.() ?? '')));
  navigation.setAttribute('aria-label', tShell('navigation'));
  navigation.hidden = role() === 'none' || links.length < 2;
  replace(navigation, h('ul', null, ...links));
}

const kLostAfter_ms = 1500;

/** A line that breaks for a moment, as at a login, is not worth a word. */
function watchBanners(banners: HTMLElement): void {
  let lost = false;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const draw = () => drawBanners(banners, lost);
  connected.watch((yes) => {
    clearTimeout(timer);
    if (yes) lost = false;
    else timer = setTimeout(() => void ((lost = true), draw()), kLostAfter_ms);
    draw();
  });
  session.watch(draw);
  language.watch(draw);
}

function drawBanners(banners: HTMLElement, lost: boolean): void {
  const now = session.value;
  const lines: [string, string][] = [];
  if (lost) lines.push(['bad', tShell('connection_lost')]);
  if (now?.store.problem) lines.push(['bad', tShell('store_problem', { problem: now.store.problem })]);
  if (now?.certificate_problem) lines.push(['warn', tShell('certificate', { problem: now.certificate_problem })]);
  const wantedText = lines.map((line) => line.join()).join();
  if (banners.dataset['text'] === wantedText) return;
  banners.dataset['text'] = wantedText;
  replace(banners, ...lines.map(([kind, text]) => h('div', { class: `banner ${kind}` }, text)));
}

/** A minute before the end of an unused session: a dialog with the seconds that are left. */
function watchTimeout(): void {
  const text = h('p', { role: 'timer' });
  let asked = false;
  secondsLeft.watch((left) => {
    text.textContent = tShell('timeout_text', { n: left ?? 0 });
    if (left === null) {
      if (asked) closeDialog();
      return;
    }
    if (asked) return;
    asked = true;
    void dialog(tShell('timeout_title'), [text], [{ answer: 'stay', text: tShell('stay'), kind: 'primary' }]).then(async (answer) => {
      asked = false;
      if (answer === 'stay') await stayLoggedIn().catch(() => {});
    });
  });
}
