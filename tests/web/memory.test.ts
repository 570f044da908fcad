// Claims: memory that is given back is used again; results stay valid when memory grows; refused calls say why and leave
// nothing behind.
import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { loader, PhynnessError, toolAt } from '../runtime/src/index.js';
import { block, bodyText, built, load, loadText, sample, textOf } from './setup.js';

describe('Model', () => {
  /** Bytes of memory do not grow from the first time to the last. */
  const expectNoGrowth = (model: unknown, act: () => void) => {
    const bytes = () => (model as { engine: { memory: WebAssembly.Memory } }).engine.memory.buffer.byteLength;
    act();
    const first = bytes();
    for (let i = 0; i < 50; ++i) act();
    expect(bytes()).toBe(first);
  };

  it('gives memory of tools, surfaces and contacts back', async () => {
    const model = await load(sample);
    expectNoGrowth(model, () => {
      const all = [model.tools(8), model.surface(3), model.contact(4)];
      for (const object of [...all, ...all]) object.dispose();
    });
    const surface = model.surface(1);
    surface.dispose();
    expect(() => surface.deform(new Float64Array(3))).toThrow('disposed');
    model.dispose();
    expect(() => model.force(0, [0, 0, 0])).toThrow('disposed');
  });

  it('keeps results and information when memory grows', async () => {
    const model = await load(sample), node = model.info.activeNodes[0]!, d = [0, 0, -0.004];
    const field = model.deform(node, d), copy = [...field], points = [...model.info.outputPoints];
    const many = Array.from({ length: 6 }, () => model.surface(4));
    expect([...field]).toEqual(copy);
    expect([...model.info.outputPoints]).toEqual(points);
    expect([...model.deform(node, d)]).toEqual(copy);
    for (const surface of many) surface.dispose();
  });

  it('refuses with the reason', async () => {
    const model = await load(sample), active = new Set(model.info.activeNodes);
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
    expect(refusal(() => model.force(inactive, [0, 0, 0])).statusName).toBe('PHN_ERROR_NOT_ACTIVE');
    expect(refusal(() => model.force([...active][0]!, [NaN, 0, 0])).statusName).toBe('PHN_ERROR_NOT_FINITE');
    expect(refusal(() => model.surface(7)).statusName).toBe('PHN_ERROR_ARGUMENT');
    expect(refusal(() => model.field([...active][0]!, [0, 0, 0], 'nothing')).status).toBeLessThan(0);
    expect(() => model.force(1.5, [0, 0, 0])).toThrow('is not a node');
    expect(() => model.force(2 ** 32 + [...active][0]!, [0, 0, 0])).toThrow('is not a node');
    expect(() => model.force([...active][0]!, [0, 0])).toThrow('2 numbers');
    expect(() => model.tools(1).set([toolAt(0, [0, 0, 0]), toolAt(1, [0, 0, 0])])).toThrow('made for 1');
  });

  it('refuses damaged texts with the byte', async () => {
    const text = textOf(sample);
    for (let at = 40; at < text.length; at += Math.ceil(text.length / 60)) {
      const damaged = text.slice();
      damaged[at] = damaged[at] === 0x31 ? 0x32 : 0x31;
      await expect(loadText(damaged)).rejects.toThrow(PhynnessError);
    }
    for (const cut of [0, 1, 100, text.length - 1])
      await expect(loadText(text.subarray(0, cut))).rejects.toThrow(PhynnessError);
    await expect(loadText(new TextEncoder().encode('phynness-model x'))).rejects.toThrow(/byte [1-9]/);
  });

  it('does not let anything use a model that was disposed', async () => {
    const model = await load(sample), tools = model.tools(1), contact = model.contact(1), surface = model.surface(1);
    const field = tools.deform();
    model.dispose();
    expect(() => tools.set([])).toThrow('model was disposed');
    expect(() => contact.step([])).toThrow('model was disposed');
    expect(() => contact.deform()).toThrow('model was disposed');
    expect(() => surface.deform(field)).toThrow('model was disposed');
  });

  it('takes and gives bodies, whose memory comes back', async () => {
    const model = await load(block);
    expectNoGrowth(model, () => {
      const body = model.body(bodyText());
      for (const object of [body.tools(2), body.contact(1, 2), body]) object.dispose();
    });
    const body = model.body(bodyText());
    for (const steps of [0, 1.5]) expect(() => body.tools(1, steps)).toThrow(RangeError);
    const tools = body.tools(2), contact = body.contact(1);
    body.dispose();
    expect(() => tools.set([])).toThrow('body was disposed');
    expect(() => contact.step([])).toThrow('body was disposed');
    model.body(new TextDecoder().decode(bodyText())).dispose();
    const damaged = bodyText();
    damaged[damaged.length >> 1] = 0x7a;
    expect(() => model.body(damaged)).toThrow(PhynnessError);
    expect(() => model.body('no body')).toThrow(/byte [1-9]/);
    model.dispose();
    expect(() => model.body(bodyText())).toThrow('disposed');
  });

  it('refuses numbers and modes that JavaScript would convert to others', async () => {
    const model = await load(sample);
    for (const bad of [0, 2.5, 9, 2 ** 32 + 1, NaN, null, '2'] as number[]) {
      expect(() => model.tools(bad)).toThrow(RangeError);
      expect(() => model.contact(bad)).toThrow(RangeError);
    }
    for (const bad of [2.5, 2 ** 32 + 1, NaN, null, '2'] as number[]) expect(() => model.surface(bad)).toThrow(RangeError);
    const contact = model.contact(1), center = [0, 0, 0], radius = 0.001;
    for (const mode of ['Grasp', 'toString'] as unknown as 'grasp'[])
      expect(() => contact.step([{ center, radius, mode }])).toThrow(RangeError);
  });

  it('loads what a browser may have: text, bytes, views; and tries again after a failure', async () => {
    const text = textOf(sample), apart = new Uint8Array(text.length + 64);
    apart.set(text, 32);
    let calls = 0;
    const fromText = loader(async () => {
      if (++calls === 1) throw new Error('no network');
      return WebAssembly.compile(new Uint8Array(readFileSync(built.wasm)));
    });
    await expect(fromText(text)).rejects.toThrow('no network');
    const all = [new TextDecoder().decode(text), text, text.buffer.slice(text.byteOffset, text.byteOffset + text.length),
      new DataView(apart.buffer, 32, text.length)];
    for (const form of all) expect((await fromText(form)).info.family).toBe('modal');
    expect(calls).toBe(2);
  });
});
