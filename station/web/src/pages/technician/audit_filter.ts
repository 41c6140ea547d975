// Lines of the audit, and which of them somebody looks for.
import type { AuditLine } from '../../core/contract';

/** Lines that hold every word that was typed, in any of their columns. */
export function matching(lines: readonly AuditLine[], typed: string): AuditLine[] {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  return lines.filter((line) => {
    const text = [line.number, line.user, line.origin, line.action, line.subject, line.result].join(' ').toLowerCase();
    return words.every((word) => text.includes(word));
  });
}
