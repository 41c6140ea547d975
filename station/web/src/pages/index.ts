// All pages. Their code is loaded when they are opened, so that the first one is there at once; what has a title is in
// the navigation, in this order, for those who may open it, and the first of them is where a role begins.
import type { PageEntry } from '../core/router';
import { tAdmin } from '../words/admin';
import { tOperator } from '../words/operator';
import { technicianEntries } from './technician/entries';

export const loginEntry: PageEntry = {
  path: '/login',
  roles: ['none'],
  title: null,
  load: async () => (await import('./shell/login')).loginPage,
};

export const pages: PageEntry[] = [
  // Operator.
  { path: '/visit', roles: ['operator'], title: () => tOperator('nav_visit'), load: async () => (await import('./operator/start')).startPage },
  { path: '/visit/customer', roles: ['operator'], title: null, load: async () => (await import('./operator/customer')).customerPage },
  { path: '/visit/consent', roles: ['operator'], title: null, load: async () => (await import('./operator/consent')).consentPage },
  { path: '/visit/checks', roles: ['operator'], title: null, load: async () => (await import('./operator/checks')).checksPage },
  { path: '/visit/stand', roles: ['operator'], title: null, load: async () => (await import('./operator/stand')).standPage },
  { path: '/visit/scan', roles: ['operator'], title: null, load: async () => (await import('./operator/scan')).scanPage },
  { path: '/scans/:scan', roles: ['operator'], title: null, load: async () => (await import('./operator/verdict')).verdictPage },
  { path: '/scans/:scan/measurements', roles: ['operator'], title: null, load: async () => (await import('./operator/measurements')).measurementsPage },
  { path: '/scans/:scan/handover', roles: ['operator'], title: null, load: async () => (await import('./operator/handover')).handoverPage },
  { path: '/customers/:customer', roles: ['operator'], title: null, load: async () => (await import('./operator/record')).recordPage },
  // Glasses and measuring by hand.
  { path: '/scans/:scan/glasses', roles: ['operator'], title: null, load: async () => (await import('./glasses/page')).glassesPage },
  { path: '/scans/:scan/measure', roles: ['operator'], title: null, load: async () => (await import('./measure/page')).measurePage },
  // Technician and developer.
  ...technicianEntries,
  // Admin.
  { path: '/admin/users', roles: ['admin'], title: () => tAdmin('nav_users'), load: async () => (await import('./admin/users')).usersPage },
  { path: '/admin/retention', roles: ['admin'], title: () => tAdmin('nav_retention'), load: async () => (await import('./admin/retention')).retentionPage },
  { path: '/admin/backup', roles: ['admin'], title: () => tAdmin('nav_backup'), load: async () => (await import('./admin/backup')).backupPage },
  { path: '/admin/audit', roles: ['admin'], title: () => tAdmin('nav_audit'), load: async () => (await import('./admin/audit')).auditPage },
  { path: '/admin/store', roles: ['admin'], title: () => tAdmin('nav_store'), load: async () => (await import('./admin/store')).storePage },
];
