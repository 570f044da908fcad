// Claim: forces and deformations are those of the native runtime. Tolerance: the exponential function of the module's C
// library differs from the host's in its last bit, and weights cancel (1e-10 of the largest value).
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { describe, expect, it } from 'vitest';
import { toolAt } from '../runtime/src/index.js';
import { block, bodyText, built, difference, golden, load, sample } from './setup.js';

describe.each(['rbfn', 'linear', 'modal'])('family %s', (family) => {
  const folder = join(built.models, family);

  it('answers golden queries', async () => {
    const model = await load(folder), queries = golden(folder);
    expect(queries.length).toBe(200);
    expect(model.info.family).toBe(family);
    expect(model.info.provenance).toMatchObject({
      element: 'p1-p1', shearModulus: 500, reference: 'half-size', finerNodes: 3000, finerProbes: 11,
      finerToolRadius: 0.03, finerMean: 0.125, finerP95: 0.25,
    });
    const expected: number[] = [], got: number[] = [], expectedField: number[] = [], gotField: number[] = [];
    for (const q of queries) {
      expected.push(...q.force);
      got.push(...model.force(q.node, q.displacement).force);
      expectedField.push(...q.deformation);
      gotField.push(...model.deform(q.node, q.displacement).subarray(3 * q.output, 3 * q.output + 3));
    }
    expect(difference(expected, got)).toBeLessThan(1e-10);
    expect(difference(expectedField, gotField)).toBeLessThan(1e-10);
  });

  it('couples one tool to the force of its place, at a node or between nodes', async () => {
    const model = await load(folder), node = model.info.activeNodes[0]!, d = [1e-4, -2e-4, 3e-4];
    const tools = model.tools(2), coupled = tools.set([toolAt(node, d)]);
    expect(difference(model.force(node, d).force, coupled.forces)).toBeLessThan(1e-12);
    expect(difference(model.deform(node, d), tools.deform())).toBeLessThan(1e-9);
    const { outputNodes, outputPoints } = model.info, at = 3 * outputNodes.indexOf(node);
    const { tool } = model.nearest(outputPoints.subarray(at, at + 3).map((x, k) => x + [0.003, 0.002, 0.001][k]!));
    expect(difference(model.force(tool, d).force, tools.set([{ ...tool, displacement: d }]).forces)).toBeLessThan(1e-12);
    expect(difference(model.deform(tool, d), tools.deform())).toBeLessThan(1e-9);
  });

  it('is touched by a sphere with the force of the tool that it holds, but for what is not balanced', async () => {
    const model = await load(folder), contact = model.contact(1), tools = model.tools(1), { activeNodes, outputNodes, outputPoints } = model.info;
    const at = outputNodes.indexOf(activeNodes[0]!), start = outputPoints.slice(3 * at, 3 * at + 3), n = outputNodes.length;
    const middle = start.map((_, k) => outputPoints.reduce((sum, x, i) => sum + (i % 3 === k ? x / n : 0), 0));
    const size = Math.hypot(...start.map((x, k) => x - middle[k]!));
    let touching = 0, largest = 0, off = 0;
    // From outside into the body beside its first active node, out again, with a sideways motion.
    for (let i = 0; i < 400; ++i) {
      const turn = (2 * Math.PI * i) / 400, out = 1 + 0.1 * Math.cos(turn);
      const center = start.map((x, k) => middle[k]! + out * (x - middle[k]!) + 0.03 * size * Math.sin(3 * turn + k));
      const [touch] = contact.step([{ center, radius: 0.05 * size, friction: 0.2 }]).touches;
      if (!touch!.held) continue;
      ++touching;
      const { forces } = tools.set([touch!.held]), left = Math.hypot(...forces.map((f, k) => f - touch!.force[k]! / touch!.scale));
      largest = Math.max(largest, ...forces.map(Math.abs));
      off = Math.max(off, Math.abs(left - touch!.unbalanced));
    }
    expect(off).toBeLessThan(1e-9 * largest);
    expect(touching).toBeGreaterThan(100);
  });
});

describe('a reduced body', () => {
  it('answers for several tools', async () => {
    const model = await load(block), [a, b] = [26, 48], body = model.body(bodyText());
    expect(body.info).toMatchObject({ meshHash: model.info.meshHash, law: 'mooney-rivlin', nModes: 120, nCells: 96, toolRadius: 0.035 });
    const tools = body.tools(2, 200), held = [toolAt(a, [0.002, 0, -0.004]), toolAt(b, [0, 0.001, 0.003])];
    const d = held.map(({ displacement }) => [...Array.from(displacement)]), at = (t: number, k: number, x: number) =>
      tools.set(held.map((tool, i) => ({ ...tool, displacement: d[i]!.map((c, j) => (i === t && j === k ? c + x : c)) })));
    const { forces, warnings, energy } = tools.set(held), h = 2e-5;
    expect(warnings).toEqual([]);
    const derivatives = [0, 1].flatMap((t) => [0, 1, 2].map((k) => (at(t, k, h).energy - at(t, k, -h).energy) / (2 * h)));
    expect(difference(forces, derivatives)).toBeLessThan(1e-3); // of the square of h
    expect(energy).toBeGreaterThan(0);
    tools.set(held);
    expect(tools.bounds().every((bound) => bound! > 0)).toBe(true);
    expect(tools.deform().length).toBe(3 * body.info.nodes.length);
    expect(Math.max(...tools.deform().map(Math.abs))).toBeGreaterThan(0.003);
    tools.set([]);
    expect(Math.max(...tools.deform().map(Math.abs))).toBe(0);
  });
  it('is touched by spheres', async () => {
    const body = (await load(block)).body(bodyText()), contact = body.contact(1), radius = 0.005;
    let touch = contact.step([{ center: [0.06, 0.06, 0.05], radius }]).touches[0]!;
    for (let i = 0; i <= 60; ++i) touch = contact.step([{ center: [0.06, 0.06, 0.035 - 1e-4 * Math.min(i, 50)], radius }]).touches[0]!;
    expect(touch.inContact).toBe(true);
    const { forces } = body.tools(1, 200).set([touch.held!]);
    expect(difference(forces.map((f) => touch.scale * f), touch.force)).toBeLessThan(1e-3);
  });
});

describe('the sample model', () => {
  it('says that its elements were not recorded', async () => {
    const { provenance } = (await load(sample)).info;
    expect(provenance.physicsHash).toMatch(/^[0-9a-f]{16}$/);
    expect(provenance).toMatchObject({ element: '', shearModulus: 0, reference: '', finerProbes: 0 });
  });

  it('has a force that is the gradient of its energy and a stiffness that is the derivative of its force', async () => {
    const model = await load(sample), node = model.info.activeNodes[0]!, d = [0.002, -0.001, -0.003], h = 1e-6;
    const at = model.force(node, d, { energy: true, stiffness: true });
    for (let k = 0; k < 3; ++k) {
      const up = d.map((x, i) => x + (i === k ? h : 0)), down = d.map((x, i) => x - (i === k ? h : 0));
      const a = model.force(node, up, { energy: true }), b = model.force(node, down, { energy: true });
      // Central differences: errors of h^2 and of rounding / h, both below 1e-6 of the size here.
      expect((a.energy! - b.energy!) / (2 * h)).toBeCloseTo(at.force[k]!, 6);
      const column = [0, 1, 2].map((i) => (a.force[i]! - b.force[i]!) / (2 * h));
      expect(difference(at.stiffness!.filter((_, i) => i % 3 === k), column)).toBeLessThan(1e-5);
    }
  });

  it('tells where it was trained', async () => {
    const model = await load(sample), node = model.info.activeNodes[0]!, { maxDisplacement } = model.info;
    expect(model.trainedDepth(node, [0, 0, -1])).toBeCloseTo(maxDisplacement, 12);
    expect(model.force(node, [0, 0, -2 * maxDisplacement]).warnings).toContain('outside');
    expect(model.force(node, [0, 0, -0.1 * maxDisplacement]).warnings).not.toContain('outside');
  });

  it('states a bound of its error inside the trained range', async () => {
    const model = await load(sample), node = model.info.activeNodes[0]!, { maxDisplacement: range } = model.info;
    expect(model.bound(node, [0, 0, 0])).toBe(0);
    expect(model.bound(node, [0, 0, -0.9 * range])).toBeGreaterThan(model.bound(node, [0, 0, -0.3 * range])!);
    expect(model.bound(node, [0, 0, -1.1 * range])).toBeNull();
    expect(() => model.bound(1e6, [0, 0, 0])).toThrow(/phn_bound/);
    const without = await load(join(built.models, 'linear'));
    expect(without.bound(without.info.activeNodes[0]!, [0, 0, -1e-3])).toBeNull();
  });
  it('has the bound of the native runtime', async () => {
    const model = await load(sample), node = model.info.activeNodes[0]!, d = [0.001, -0.002, -0.004];
    const json = join(mkdtempSync(join(tmpdir(), 'phynness-web-')), 'eval.json');
    execFileSync(built.phynness, ['eval', sample, '--node', String(node), '--displacement', d.join(','), '--json', json]);
    const { bound_N: bound } = JSON.parse(readFileSync(json, 'utf8')) as { bound_N: number };
    expect(Math.abs(model.bound(node, d)! - bound)).toBeLessThan(1e-12 * bound);
  });

  it('bounds tools that are set, and says where it cannot', async () => {
    const model = await load(sample), [a, b] = model.info.activeNodes as unknown as [number, number], d = [0.001, -0.002, -0.004];
    const tools = model.tools(2);
    tools.set([toolAt(a, d)]);
    expect(tools.bounds()).toEqual([model.bound(a, d)]);
    tools.set([toolAt(a, [0, 0, -2 * model.info.maxDisplacement])]);
    expect(tools.bounds()).toEqual([null]);
    tools.set([toolAt(a, d), toolAt(b, d)]); // the sample was calibrated at nodes only
    expect(tools.bounds()).toEqual([null, null]);
    tools.set([]);
    expect(tools.bounds()).toEqual([]);
    expect(() => tools.set([toolAt(-5, d)])).toThrow();
    expect(tools.bounds()).toEqual([]);
  });

  it('finds the nearest point, and subdivides', async () => {
    const model = await load(sample), { outputPoints, outputNodes } = model.info;
    const touched = model.info.activeNodes[0]!, at = 3 * outputNodes.indexOf(touched);
    const { tool, point, distance } = model.nearest(outputPoints.subarray(at, at + 3));
    expect(tool.nodes).toContain(touched);
    expect(Math.abs(distance)).toBeLessThan(1e-12);
    expect(difference(outputPoints.subarray(at, at + 3), point)).toBeLessThan(1e-9);
    const node = model.info.activeNodes[0]!, field = model.deform(node, [0, 0, -0.005]);
    const sizes = [0, 1, 2, 3].map((levels) => {
      const surface = model.surface(levels), moved = surface.deform(field);
      expect(moved.length).toBe(3 * surface.nVertices);
      expect(Math.max(...moved.map(Math.abs))).toBeGreaterThan(0.001);
      const n = surface.triangles.length / 3;
      surface.dispose();
      return n;
    });
    expect(sizes).toEqual([1, 4, 16, 64].map((f) => f * sizes[0]!));
  });

  it('is an npm package for browsers without a module of Node', () => {
    const browser = readFileSync(join(built.package, 'browser.js'), 'utf8');
    expect(browser).not.toMatch(/node:|require\(/);
    expect(readFileSync(join(built.package, 'node.js'), 'utf8')).toContain('node:fs/promises');
  });
});
