import { describe, expect, it } from 'vitest';
import { emptyPlan, type FaultPlan, faultOf, isProblem, planText, readPlan, replayKinds } from './fault_plan';

const problem = (text: string) => {
  const read = readPlan(text);
  return isProblem(read) ? read : null;
};

describe('a fault plan as text', () => {
  it('is written so that it reads back', () => {
    const plan = emptyPlan();
    plan.faults.push(faultOf(replayKinds[0]!, 40, 0.3), faultOf(replayKinds.find((one) => one.kind === 'overflow')!, 7, 0.3));
    const back = readPlan(planText(plan)) as FaultPlan;
    expect(back).toEqual(plan);
    expect(back.faults[0]).toEqual({ at: { level: 40 }, target: 'usb', kind: 'unplug', for_s: 0.3, args: { board: 3, not_ready_s: 0 } });
  });
  it('gives what happens once no length', () => {
    expect(faultOf({ target: 'can', kind: 'overflow', args: { frames: 20 }, once: true }, 7, 0.3)).toEqual({ at: { level: 7 }, target: 'can', kind: 'overflow', args: { frames: 20 } });
  });
  it('of nothing reads back, too', () => expect(readPlan(planText(emptyPlan()))).toEqual(emptyPlan()));
});

describe('what is wrong with a plan', () => {
  it('is told with its line', () => {
    expect(problem('{\n  "format": "annulus fault plan", "version": 1,\n  "faults": [ oops ]\n}')?.line).toBe(3);
    expect(problem('{\n  "format": "something"\n}')?.line).toBe(2);
    expect(problem('{\n"format": "annulus fault plan",\n\n"version": 2}')?.line).toBe(4);
  });
  it('is a list that is none, or a fault that lacks something', () => {
    expect(problem('{"format": "annulus fault plan", "version": 1, "faults": {}}')?.text).toContain('"faults"');
    expect(problem('{"format": "annulus fault plan", "version": 1, "faults": [{"kind": "lose", "target": "can"}]}')?.text).toContain('fault 1');
    expect(problem('[1, 2]')?.text).toContain('object');
  });
});
