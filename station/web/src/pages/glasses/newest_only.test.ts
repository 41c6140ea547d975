import { describe, expect, it } from 'vitest';
import { NewestOnly } from './newest_only';

/** A server whose answers are let go by hand. */
function server() {
  const asked: number[] = [];
  const open: { resolve(value: string): void; reject(error: Error): void }[] = [];
  return {
    asked,
    send: (question: number): Promise<string> => {
      asked.push(question);
      return new Promise((resolve, reject) => open.push({ resolve, reject }));
    },
    async answer(): Promise<void> {
      open.shift()!.resolve(`answer ${asked.at(-1)}`);
      await settled();
    },
    async fail(): Promise<void> {
      open.shift()!.reject(new Error('away'));
      await settled();
    },
  };
}

async function settled(): Promise<void> {
  for (let i = 0; i < 5; ++i) await Promise.resolve();
}

describe('requests that follow a hand', () => {
  it('never runs two at once, and sends only the newest of what waited', async () => {
    const { asked, send, answer } = server();
    const answers: string[] = [];
    const feed = new NewestOnly(send, (text) => answers.push(text), () => {});
    for (const question of [1, 2, 3, 4]) feed.ask(question);
    expect(asked).toEqual([1]);
    await answer();
    expect(asked).toEqual([1, 4]);
    expect(feed.idle).toBe(false);
    await answer();
    expect(answers).toEqual(['answer 1', 'answer 4']);
    expect(feed.idle).toBe(true);
  });

  it('goes on after a failure, with the newest', async () => {
    const { asked, send, fail, answer } = server();
    const failures: number[] = [];
    const answers: string[] = [];
    const feed = new NewestOnly(send, (text) => answers.push(text), (_, question) => failures.push(question));
    feed.ask(1);
    feed.ask(2);
    await fail();
    expect(failures).toEqual([1]);
    expect(asked).toEqual([1, 2]);
    await answer();
    expect(answers).toEqual(['answer 2']);
  });

  it('drops what comes after its end', async () => {
    const { asked, send, answer } = server();
    const answers: string[] = [];
    const feed = new NewestOnly(send, (text) => answers.push(text), () => {});
    feed.ask(1);
    feed.ask(2);
    feed.end();
    await answer();
    feed.ask(3);
    expect(answers).toEqual([]);
    expect(asked).toEqual([1]);
  });
});
