import { defineConfig } from 'vite';

// `npm run build -- --outDir DIR` writes to the folder beside the program. What is inlined would be refused by the
// page's content security policy, so nothing is.
export default defineConfig({
  base: '/',
  build: {
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: 'es2022',
    chunkSizeWarningLimit: 900,
  },
});
