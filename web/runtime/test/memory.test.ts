// Claims: memory that is given back is used again; results stay valid when memory grows; refused calls say why and leave
// nothing behind.
import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
// @ts-expect-error a script without types
import { layoutOf } from '../../wasm/layout.mjs';
import { Heap } from '../src/heap.js';
import { PhynnessError, toolAt } from '../src/index.js';
import { layout } from '../src/layout.js';
import { built, load, loadText, sample, textOf } from './setup.js';

describe('Heap', () => {
  it('never gives two blocks that overlap, and joins free ones', () => {
    const memory = new WebAssembly.Memory({ initial: 1 }), heap = new Heap(memory, 1000);
    const blocks = new Map<number, number>();
    let state = 1;
    const random = (n: number) => {
      state = (state * 48271) % 2147483647;
      return state % n;
    };
    for (let i = 0; i < 4000; ++i) {
      if (random(2) === 0 || blocks.size === 0) {
        const bytes = 1 + random(5000), at = heap.take(bytes);
        expect(at % 16).toBe(0);
        expect(at).toBeGreaterThanOrEqual(1000);
        expect(at + bytes).toBeLessThanOrEqual(memory.buffer.byteLength);
        for (const [other, size] of blocks) expect(at + bytes <= other || other + size <= at).toBe(true);
        blocks.set(at, bytes);
      } else {
        const at = [...blocks.keys()][random(blocks.size)]!;
        heap.give(at);
        blocks.delete(at);
      }
    }
    for (const at of blocks.keys()) heap.give(at);
    expect(heap.used).toBe(0);
    expect(heap.take(16)).toBe(1008);
    expect(() => heap.give(64)).toThrow('no block');
  });
});

describe('Model', () => {
  const heapOf = (model: unknown) => (model as { engine: { heap: Heap } }).engine.heap;

  it('gives memory of tools, surfaces and contacts back', () => {
    const model = load(sample), heap = heapOf(model), before = heap.used;
    for (let i = 0; i < 50; ++i) {
      const all = [model.tools(8), model.surface(3), model.contact(4)];
      expect(heap.used).toBeGreaterThan(before);
      for (const object of all) object.dispose();
      for (const object of all) object.dispose();
      expect(heap.used).toBe(before);
    }
    const surface = model.surface(1);
    surface.dispose();
    expect(() => surface.deform(new Float64Array(3))).toThrow('disposed');
    model.dispose();
    expect(heap.used).toBe(0);
    expect(() => model.force(0, [0, 0, 0])).toThrow('disposed');
  });

  it('keeps results and information when memory grows', () => {
    const model = load(sample), node = model.info.activeNodes[0]!, d = [0, 0, -0.004];
    const field = model.deform(node, d), copy = [...field], points = [...model.info.outputPoints];
    const many = Array.from({ length: 6 }, () => model.surface(4));
    expect([...field]).toEqual(copy);
    expect([...model.info.outputPoints]).toEqual(points);
    expect([...model.deform(node, d)]).toEqual(copy);
    for (const surface of many) surface.dispose();
  });

  it('refuses with the reason', () => {
    const model = load(sample), active = new Set(model.info.activeNodes);
    const refusal = (call: () => unknown): PhynnessError => {
      try {
        call();
      } catch (error) {
        expect(error).toBeInstanceOf(PhynnessError);
        return error as PhynnessError;
      }
      throw new Error('not refused');
    };
    const inactive = [...Array(model.info.nNodes).keys()].find((node) => !active.has(node))!;
    const heap = heapOf(model), before = heap.used;
    expect(refusal(() => model.force(inactive, [0, 0, 0])).statusName).toBe('PHN_ERROR_NOT_ACTIVE');
    expect(refusal(() => model.force([...active][0]!, [NaN, 0, 0])).statusName).toBe('PHN_ERROR_NOT_FINITE');
    expect(refusal(() => model.surface(7)).statusName).toBe('PHN_ERROR_ARGUMENT');
    expect(refusal(() => model.tools(0)).statusName).toBe('PHN_ERROR_ARGUMENT');
    expect(refusal(() => model.field([...active][0]!, [0, 0, 0], 'nothing')).status).toBeLessThan(0);
    expect(() => model.force(1.5, [0, 0, 0])).toThrow('not an integer');
    expect(() => model.force(2 ** 32 + [...active][0]!, [0, 0, 0])).toThrow('not an integer');
    expect(() => model.force([...active][0]!, [0, 0])).toThrow('2 numbers');
    expect(() => model.tools(1).set([toolAt(0, [0, 0, 0]), toolAt(1, [0, 0, 0])])).toThrow('made for 1');
    expect(heap.used - before).toBeLessThan(1e6);
  });

  it('refuses damaged texts with the byte', () => {
    const text = textOf(sample);
    for (let at = 40; at < text.length; at += Math.ceil(text.length / 60)) {
      const damaged = text.slice();
      damaged[at] = damaged[at] === 0x31 ? 0x32 : 0x31;
      try {
        loadText(damaged);
        expect.unreachable(`byte ${at} was changed`);
      } catch (error) {
        expect(error).toBeInstanceOf(PhynnessError);
        expect((error as PhynnessError).status).toBeLessThan(0);
      }
    }
    for (const cut of [0, 1, 100, text.length - 1])
      expect(() => loadText(text.subarray(0, cut))).toThrow(PhynnessError);
    const bad = new TextEncoder().encode('phynness-model x');
    try {
      loadText(bad);
      expect.unreachable();
    } catch (error) {
      expect((error as PhynnessError).wrongByte).toBeGreaterThan(0);
      expect((error as PhynnessError).message).toContain('byte');
    }
  });
});

describe('layout.ts', () => {
  it('has the offsets of the compiler', () => {
    expect(layout).toEqual(layoutOf(readFileSync(built.layout)));
  });
});
