import './styles/tokens.css';
import './styles/base.css';
import './styles/shell.css';
import './styles/parts.css';
import './styles/operator.css';
import { watchBooth } from './core/booth';
import { restoreLook } from './core/look';
import { loadSession, watchSession } from './core/session';
import { startShell } from './core/shell';
import { watchStopKeys } from './core/stop';
import { loginEntry, pages } from './pages';
import { watchVisit } from './pages/operator/visit';

/** Asks until the station answers: a page that was opened before it is up comes to life by itself. */
async function begin(): Promise<void> {
  try {
    await loadSession();
  } catch {
    setTimeout(() => void begin(), 1000);
  }
}

restoreLook();
watchStopKeys();
watchSession();
watchBooth();
watchVisit();
const app = document.getElementById('app');
if (app) startShell(app, pages, loginEntry);
void begin();
