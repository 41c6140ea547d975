// A page that fills what header, navigation and banners leave of the window.

const least_px = 480;

/** Keeps the element's height; what is returned ends that. On a narrow window the page's own style decides. */
export function fillWindow(element: HTMLElement): () => void {
  const narrow = matchMedia('(max-width: 800px)');
  const fit = (): void => {
    const top = element.getBoundingClientRect().top + window.scrollY;
    const height = Math.max(least_px, Math.floor(window.innerHeight - top - 16));
    element.style.height = narrow.matches ? '' : `${height}px`;
  };
  // Banners come and go above: what they change is the place of the page's own root.
  const above = new ResizeObserver(fit);
  for (let sibling = element.closest('main')?.previousElementSibling; sibling; sibling = sibling.previousElementSibling) above.observe(sibling);
  addEventListener('resize', fit);
  fit();
  return () => {
    above.disconnect();
    removeEventListener('resize', fit);
  };
}
