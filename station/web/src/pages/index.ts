// All pages. Their code is loaded when they are opened, so that the first one is there at once; what has a title is in
// the navigation, in this order, for those who may open it, and the first of them is where a role begins.
import type { PageEntry } from '../core/router';
import { technicianEntries } from './technician/entries';

export const loginEntry: PageEntry = {
  path: '/login',
  roles: ['none'],
  title: null,
  load: async () => (await import('./shell/login')).loginPage,
};

export const pages: PageEntry[] = [
  // Operator.
  // Glasses and measuring by hand.
  // Technician and developer.
  ...technicianEntries,
  // Admin.
];
