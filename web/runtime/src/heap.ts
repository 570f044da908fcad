// Memory of a module above its own data: blocks are taken and given back. Addresses and sizes are multiples of 16.

const unit = 16;
const page = 65536;
const roundedUp = (n: number) => Math.ceil(n / unit) * unit;

export class Heap {
  /** Free blocks in ascending order; no two of them touch. */
  private readonly free: { at: number; bytes: number }[] = [];
  private readonly taken = new Map<number, number>();
  private top: number;

  constructor(
    private readonly memory: WebAssembly.Memory,
    begin: number,
  ) {
    this.top = roundedUp(begin);
  }

  /** Bytes that are in use. */
  get used(): number {
    let sum = 0;
    for (const bytes of this.taken.values()) sum += bytes;
    return sum;
  }

  /** The address of a new block. @throws RangeError if the engine refuses more memory */
  take(bytes: number): number {
    const size = Math.max(unit, roundedUp(bytes));
    const index = this.free.findIndex((block) => block.bytes >= size);
    const block = this.free[index];
    let at: number;
    if (block) {
      at = block.at;
      block.at += size;
      block.bytes -= size;
      if (block.bytes === 0) this.free.splice(index, 1);
    } else {
      at = this.top;
      const missing = at + size - this.memory.buffer.byteLength;
      if (missing > 0) this.memory.grow(Math.ceil(missing / page));
      this.top = at + size;
    }
    this.taken.set(at, size);
    return at;
  }

  /** Gives a block back. */
  give(at: number): void {
    const bytes = this.taken.get(at);
    if (bytes === undefined) throw new Error(`no block of memory begins at ${at}`);
    this.taken.delete(at);
    let index = this.free.findIndex((block) => block.at > at);
    if (index < 0) index = this.free.length;
    this.free.splice(index, 0, { at, bytes });
    this.join(index);
    this.join(index - 1);
    const last = this.free.at(-1);
    if (last && last.at + last.bytes === this.top) {
      this.top = last.at;
      this.free.pop();
    }
  }

  private join(index: number): void {
    const block = this.free[index];
    const next = this.free[index + 1];
    if (!block || !next || block.at + block.bytes !== next.at) return;
    block.bytes += next.bytes;
    this.free.splice(index + 1, 1);
  }
}
