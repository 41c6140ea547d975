// The technician's and the developer's pages in the navigation.
import type { PageEntry } from '../../core/router';
import { wordsOf } from '../../core/words';

const t = wordsOf({
  sensors: ['Sensors', 'センサー'],
  axis: ['Axis', '昇降軸'],
  doctor: ['Doctor', '診断'],
  calibration: ['Calibration', '校正'],
  drift: ['Drift', 'ドリフト'],
  parameters: ['Parameters', 'パラメーター'],
  recordings: ['Recordings', '記録'],
  audit: ['Audit', '監査'],
  replay: ['Replay', 'リプレイ'],
});

export const technicianEntries: PageEntry[] = [
  { path: '/technician/sensors', roles: ['technician'], title: () => t('sensors'), load: async () => (await import('./sensors')).sensorsPage },
  { path: '/technician/axis', roles: ['technician'], title: () => t('axis'), load: async () => (await import('./axis')).axisPage },
  { path: '/technician/doctor', roles: ['technician'], title: () => t('doctor'), load: async () => (await import('./doctor')).doctorPage },
  { path: '/technician/calibration', roles: ['technician'], title: () => t('calibration'), load: async () => (await import('./calibration')).calibrationPage },
  { path: '/technician/drift', roles: ['technician'], title: () => t('drift'), load: async () => (await import('./drift')).driftPage },
  { path: '/technician/parameters', roles: ['technician'], title: () => t('parameters'), load: async () => (await import('./parameters')).parametersPage },
  { path: '/technician/recordings', roles: ['technician'], title: () => t('recordings'), load: async () => (await import('./recordings')).recordingsPage },
  { path: '/developer', roles: ['technician'], title: () => t('replay'), load: async () => (await import('../developer/choose')).choosePage },
  { path: '/developer/replay/:scan', roles: ['technician'], title: null, load: async () => (await import('../developer/replay')).replayPage },
  { path: '/technician/audit', roles: ['technician'], title: () => t('audit'), load: async () => (await import('./audit')).auditPage },
];
