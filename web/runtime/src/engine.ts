// One instance of phynness.wasm with its memory.
import { layout, readable } from './layout.js';
import { PhynnessError } from './status.js';

type Functions = Readonly<Record<string, (...args: number[]) => number>>;
type Member = keyof typeof layout;

export const bytesOf = (member: Member): number => layout[member];

export class Engine {
  readonly f: Functions;
  private readonly memory: WebAssembly.Memory;

  /** Browsers refuse to instantiate larger modules synchronously on the main thread. */
  static async of(module: WebAssembly.Module): Promise<Engine> {
    return new Engine(await WebAssembly.instantiate(module, {}));
  }
  private constructor({ exports }: WebAssembly.Instance) {
    this.memory = exports['memory'] as WebAssembly.Memory;
    this.f = exports as unknown as Functions;
    this.f['__wasm_call_ctors']!();
    for (const [name, bytes] of Object.entries(layout)) {
      if (!name.includes('.') && this.sizeOf(name) !== bytes) throw new Error(`phynness.wasm is of another version: ${name}`);
    }
  }

  private sizeOf(name: string): number {
    const at = this.take(name.length + 1);
    this.bytes(at, name.length + 1).set([...new TextEncoder().encode(name), 0]);
    const bytes = this.f['phn_sizeof']!(at);
    this.give(at);
    return bytes;
  }

  /** @throws PhynnessError if the status is below 0 */
  call(name: string, ...args: number[]): number {
    const status = this.f[name]!(...args);
    if (status < 0) throw this.error(status, name);
    return status;
  }
  error(status: number, call: string, wrongByte?: number): PhynnessError {
    return new PhynnessError(status, this.text(this.f['phn_status_message']!(status)), call, wrongByte);
  }

  /** The address of a block of memory for `give`. @throws RangeError if the engine refuses more memory */
  take(bytes: number): number {
    const at = this.f['malloc']!(Math.max(1, bytes)) >>> 0;
    if (at === 0) throw new RangeError(`there is no memory for ${bytes} bytes`);
    return at;
  }
  give(at: number): void {
    this.f['free']!(at);
  }

  // Views are made anew at each use: memory that grows makes old ones unusable.
  reals(at: number, n: number): Float64Array {
    return new Float64Array(this.memory.buffer, at, n);
  }
  floats(at: number, n: number): Float32Array {
    return new Float32Array(this.memory.buffer, at, n);
  }
  integers(at: number, n: number): Int32Array {
    return new Int32Array(this.memory.buffer, at, n);
  }
  bytes(at: number, n: number): Uint8Array {
    return new Uint8Array(this.memory.buffer, at, n);
  }
  integer(at: number): number {
    return this.integers(at, 1)[0]!;
  }
  /** A size_t or an address. */
  size(at: number): number {
    return this.integer(at) >>> 0;
  }
  real(at: number): number {
    return this.reals(at, 1)[0]!;
  }
  /** The numbers and texts of the struct at an address. @template T  names them in camel case, without units */
  read<T>(struct: string, at: number): T {
    const of = { integer: (a: number) => this.integer(a), real: (a: number) => this.real(a), text: (a: number) => this.text(this.size(a)) };
    return Object.fromEntries(readable[struct]!.map(({ key, read, offset }) => [key, of[read](at + offset)])) as T;
  }
  /** A text that ends with a 0; empty for a null pointer. */
  text(at: number): string {
    if (at === 0) return '';
    const all = new Uint8Array(this.memory.buffer);
    return new TextDecoder().decode(all.slice(at, all.indexOf(0, at)));
  }
}

/** Gives blocks of memory back when the object that used them is collected without dispose(). */
const forgotten = new FinalizationRegistry<() => void>((release) => release());

/** An object that owns blocks of the memory of an engine. */
export abstract class Owner {
  private readonly blocks: number[] = [];
  private disposed = false;

  /** @param parent  whose memory this object uses, too; it is not collected before this one */
  protected constructor(
    protected readonly engine: Engine,
    private readonly parent?: Owner,
  ) {
    const { blocks } = this;
    forgotten.register(this, () => release(engine, blocks), this);
  }
  protected take(bytes: number): number {
    const block = this.engine.take(bytes);
    this.blocks.push(block);
    return block;
  }
  /** An object of the C interface in memory of this one: `size(result)` gives its bytes, `init(memory, bytes, result)` makes it. */
  protected constructed(size: (result: number) => void, init: (memory: number, bytes: number, result: number) => void): number {
    const { engine } = this, result = this.take(4);
    size(result);
    const bytes = engine.size(result);
    init(this.take(bytes), bytes, result);
    return engine.size(result);
  }
  /** The same by the functions NAME_size and NAME_init. @param more  arguments of init */
  protected made(name: string, model: number, n: number, ...more: readonly number[]): number {
    const { engine } = this;
    return this.constructed(
      (result) => engine.call(`${name}_size`, model, n, result),
      (block, bytes, result) => engine.call(`${name}_init`, block, bytes, model, n, ...more, result),
    );
  }
  /** A model or a body from its text. @throws PhynnessError with the reason and the byte */
  protected loaded(what: 'model' | 'body', text: Uint8Array): number {
    const { engine } = this, bytes = engine.take(text.byteLength), wrong = engine.take(4);
    engine.bytes(bytes, text.byteLength).set(text);
    const call = (name: string, ...args: number[]) => {
      const status = engine.f[`phn_${what}_${name}`]!(...args);
      if (status < 0) throw engine.error(status, `${what}.txt`, engine.size(wrong));
    };
    try {
      return this.constructed(
        (result) => call('size', bytes, text.byteLength, result, wrong),
        (memory, size, result) => call('init', memory, size, bytes, text.byteLength, result, wrong),
      );
    } finally {
      engine.give(wrong);
      engine.give(bytes);
    }
  }
  /** @throws Error after dispose() of this object or of its parent */
  protected alive(): void {
    if (this.disposed) throw new Error(`this ${this.what} was disposed`);
    this.parent?.alive();
  }
  /** For messages. */
  protected abstract readonly what: string;
  /** Gives the memory back. The object must not be used afterwards; a second call does nothing. */
  dispose(): void {
    if (this.disposed) return;
    this.disposed = true;
    forgotten.unregister(this);
    release(this.engine, this.blocks);
  }
}

function release(engine: Engine, blocks: number[]): void {
  for (const block of blocks.splice(0)) engine.give(block);
}

/** Contents of a model.txt or a body.txt. */
export type ModelText = string | ArrayBufferView | ArrayBuffer;

export function bytesOfText(text: ModelText): Uint8Array {
  if (typeof text === 'string') return new TextEncoder().encode(text);
  if (ArrayBuffer.isView(text)) return new Uint8Array(text.buffer, text.byteOffset, text.byteLength);
  return new Uint8Array(text);
}

/** `out` filled with the values, or a copy of them. */
export function copied<Values extends Float64Array | Float32Array>(values: Values, out?: Values): Values {
  if (!out) return values.slice() as Values;
  out.set(values);
  return out;
}

/** Other numbers would become another integer by conversion to 32 bits. @throws RangeError */
export function integer(n: number): number {
  if (!Number.isInteger(n) || Math.abs(n) > 0x7fffffff) throw new RangeError(`${n} is not an integer`);
  return n;
}

/** A number of tools or spheres. @throws RangeError */
export function few(n: number): number {
  if (!Number.isInteger(n) || n < 1 || n > 8) throw new RangeError(`${n} is not a number of tools from 1 to 8`);
  return n;
}
