// Requests that follow a hand: never two at once, and never an old one after a newer.

/**
 * Runs one request at a time. While it is under way only the newest of what was asked for waits; what came between is
 * never sent. So the server is asked as fast as it answers, and the last state is always asked for.
 */
export class NewestOnly<Question, Answer> {
  #running = false;
  #waiting: { question: Question } | null = null;
  #ended = false;

  /** `failed` is told of what a request threw; the next one is sent all the same. */
  constructor(
    private readonly send: (question: Question) => Promise<Answer>,
    private readonly answered: (answer: Answer, question: Question) => void,
    private readonly failed: (error: unknown, question: Question) => void,
  ) {}

  get idle(): boolean {
    return !this.#running && this.#waiting === null;
  }

  ask(question: Question): void {
    if (this.#ended) return;
    this.#waiting = { question };
    if (!this.#running) void this.#run();
  }

  /** Sends nothing more; answers still under way are dropped. */
  end(): void {
    this.#ended = true;
    this.#waiting = null;
  }

  async #run(): Promise<void> {
    this.#running = true;
    while (this.#waiting) {
      const { question } = this.#waiting;
      this.#waiting = null;
      try {
        const answer = await this.send(question);
        if (!this.#ended) this.answered(answer, question);
      } catch (error) {
        if (!this.#ended) this.failed(error, question);
      }
    }
    this.#running = false;
  }
}
