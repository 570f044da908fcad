// What the page computes without a page: tools and spheres, parts of the surface, the curve, states and maps.
import { describe, expect, test } from 'vitest';
import { inwardAt } from './inward.js';
import { block, bodyText, load, sample } from './setup.js';
import { dot, norm, row, scale, sub, zero, type V3 } from '../shared/src/vectors.js';
import { Runtime } from '../view/src/answers.js';
import { mapsOf, onSurface } from '../view/src/maps.js';
import { alongRay, pageDataOf } from '../view/src/page_data.js';
import { sharesOf } from '../view/src/parts.js';
import { placeAt } from '../view/src/places.js';
import { drawn } from '../view/src/plot.js';
import { curveOf, digitsOf, statesOf } from '../view/src/readouts.js';
import { Session } from '../view/src/session.js';

const session = async (json = '{}') => new Session(new Runtime(await load(sample)), pageDataOf(json));
/** A tool that holds a node. */
const hold = (s: Session, node: number, displacement: V3) => {
  const tool = s.hold(placeAt(node));
  s.move(tool, displacement);
  s.update();
  return tool;
};

describe('tools', () => {
  test('a place that is held already keeps its tool, and another one takes its turn', async () => {
    const s = await session(), [a, b] = s.runtime.model.info.activeNodes as unknown as [number, number];
    const tool = hold(s, a, [0.002, 0, 0]);
    expect(hold(s, a, [0.002, 0.003, 0])).toBe(tool);
    hold(s, b, zero);
    expect(s.tools).not.toContain(tool);
  });
  test('stop at twice the trained depth, which is said', async () => {
    const s = await session(), tool = hold(s, s.runtime.model.info.activeNodes[0]!, [1, 0, 0]);
    expect(norm(tool.at)).toBeCloseTo(s.limit, 12);
    expect(statesOf(s).map(([, word]) => word)).toEqual(expect.arrayContaining(['at its limit', 'beyond data']));
  });
  test('a place between nodes moves by the mean of its nodes, and a held node as its tool', async () => {
    const s = await session(), { runtime } = s, { activeNodes, triangles, outputNodes } = runtime.model.info, node = activeNodes[0]!;
    hold(s, node, [0.002, 0.001, 0]);
    runtime.displacementAt(placeAt(node)).forEach((u, k) => expect(u).toBeCloseTo([0.002, 0.001, 0][k]!, 12));
    const t = Array.from({ length: triangles.length / 3 }, (_, i) => triangles.slice(3 * i, 3 * i + 3))
      .find((corners) => corners.every((c) => c < outputNodes.length))!;
    const nodes = [...t].map((c) => outputNodes[c]!), weights = [0.2, 0.3, 0.5];
    const mean = [0, 1, 2].map((k) => nodes.reduce((sum, n, i) => sum + weights[i]! * runtime.displacementAt(placeAt(n))[k]!, 0));
    runtime.displacementAt({ nodes, weights }).forEach((u, k) => expect(u).toBeCloseTo(mean[k]!, 12));
  });
  test('hold places between probed nodes of node probes, too', async () => {
    const s = await session(), { activeNodes, triangles, outputNodes } = s.runtime.model.info;
    const corners = Array.from({ length: triangles.length / 3 }, (_, i) => [...triangles.slice(3 * i, 3 * i + 3)].map((c) => outputNodes[c]!))
      .find((nodes) => nodes.every((node) => activeNodes.includes(node)))!;
    s.move(s.hold({ nodes: corners, weights: [0.2, 0.3, 0.5] }), [0.001, 0.002, 0.003]);
    s.update();
    expect(s.problem).toBeNull();
    expect(norm(s.answer.forces[0]!)).toBeGreaterThan(0);
  });
});

test('parts of the surface: probed nodes are held, fixed ones are not, and the shares of the free surface add up to 1', async () => {
  const s = await session(), { activeNodes, fixedNodes } = s.runtime.model.info;
  for (const node of activeNodes) expect(s.placeNear(s.runtime.point(node)).part).toBe('nonlinear');
  // In the middle of the fixed part; beside its rim the nearest place can be touched.
  const parts = [...fixedNodes].map((node) => s.placeNear(s.runtime.point(node)).part);
  expect(parts).toContain('fixed');
  const { nonlinear, linear, untouchable } = sharesOf(s.runtime);
  expect(nonlinear).toBeGreaterThan(0);
  expect(nonlinear + linear + untouchable).toBeCloseTo(1, 12);
});

describe('the curve', () => {
  const ray = (node: number) => JSON.stringify({ rays: [{ node, direction: [0, 0, 1], depth_m: [0.005, 0.01], force_N: [[0, 0, 1], [0, 0, 2]] }] });
  test('compares the model with finite elements in the same direction only', async () => {
    const node = (await session()).runtime.model.info.activeNodes[0]!, s = await session(ray(node));
    hold(s, node, [0.001, 0, 0.004]);
    expect(curveOf(s)!.stored).toBeNull();
    hold(s, node, [0, 0, 0.004]);
    const { stored, curve } = curveOf(s)!, at = curve.depths.at(-1)!;
    expect(stored!.forces).toEqual([1, 2]);
    expect(curve.forces.at(-1)).toBeCloseTo(norm(s.runtime.model.force(node, [0, 0, at]).force as unknown as V3), 12);
  });
  test('is along a stored direction if tools follow these', async () => {
    const node = (await session()).runtime.model.info.activeNodes[0]!, s = await session(ray(node));
    s.probedOnly = true;
    expect(hold(s, node, [0.001, 0, 0.004]).at).toEqual([0, 0, 0.004]);
    expect(curveOf(s)!.stored).not.toBeNull();
    expect(alongRay(s.data.rays, node, [0, 0, -1])).toEqual([0, 0, 0]);
    expect(alongRay([], node, [1, 2, 3])).toEqual([1, 2, 3]);
  });
  test('is drawn with its finite elements and now, in the picture', () => {
    const svg = drawn({ curve: { depths: [0, 0.01], forces: [0, 2] }, stored: { depths: [0.005, 0.01], forces: [1, 2.1] }, now: { depth: 0.004, force: 0.7 } });
    const at = [...svg.matchAll(/c[xy]="([-\d.]+)"/g)].map(([, number]) => Number(number));
    expect(at.length).toBe(6);
    at.forEach((pixel) => expect(pixel > 0 && pixel < 340).toBe(true));
    expect(svg).toMatch(/<polyline points="52.0,152.0 330.0,\d/);
  });
});

test.each([[0.2934, null, 3], [0.2934, 0.0039, 3], [0.2934, 0.0587, 2], [0.2, 0.1, 1], [0.02, 0.3, 1], [1.2, 0.0001, 3]])(
  'a force of %d N with the bound %s has %d digits', (force, bound, digits) => expect(digitsOf(force, bound)).toBe(digits));

test('a body answers two tools and two spheres, and goes on until it rests', async () => {
  const runtime = new Runtime(await load(block), new TextDecoder().decode(bodyText())), s = new Session(runtime, pageDataOf('{}'));
  s.setMost(2);
  hold(s, 26, [0.002, 0, -0.006]);
  hold(s, 48, [0, 0, 0.004]);
  let pictures = 1;
  for (; s.restless; ++pictures) s.update(false);
  expect(pictures).toBeGreaterThan(1);
  expect(pictures).toBeLessThan(20);
  expect(s.problem).toBeNull();
  expect(s.answer.warnings).toEqual([]);
  s.answer.bounds.forEach((bound) => expect(bound).toBeGreaterThan(0));
  const { forces } = s.answer;
  s.update();
  s.answer.forces.forEach((force, i) => expect(norm(sub(force, forces[i]!))).toBeLessThan(1e-9 * norm(forces[i]!))); // comes closer with every call
  s.letGo();
  s.update();
  expect(Math.max(...runtime.field.map(Math.abs))).toBe(0);
  // Nodes 26 and 48 lie in the upper face.
  s.setMode('sphere');
  const { radius } = s.sphere;
  [26, 48].forEach((node, i) => s.putSphere(s.tools[i]!, runtime.point(node), [0, 0, 1]));
  for (let i = 0; i < 20; ++i) {
    s.tools.forEach((tool, k) => s.move(tool, [...runtime.point([26, 48][k]!)].map((x, c) => (c === 2 ? x + radius - 1e-4 * i : x)) as unknown as V3));
    s.update();
  }
  expect(s.answer.forces.length).toBe(2);
  s.answer.forces.forEach((force) => expect(-force[2]).toBeGreaterThan(0.001));
});

test('maps keep the values of nodes on the surface', async () => {
  const { runtime } = await session(), nodes = [...runtime.model.info.activeNodes], force_error = nodes.map((_, i) => 0.01 * (i + 1));
  const map = mapsOf(runtime, { nodes, force_error, displacement_error: force_error })[0]!.values([]), drawn = onSurface(runtime.model.surface(0), map);
  expect(map.known.reduce((a, b) => a + b, 0)).toBe(nodes.length);
  map.values.forEach((value, i) => {
    if (map.known[i] === 1) expect(Math.abs(drawn.values[i]! - value)).toBeLessThan(1e-6 * map.scale.high); // single precision
  });
});

test.each([1, 5])('the map of stiffness at %d mm is the force of an inward push over its depth, at every node that can be touched', async (mm) => {
  const runtime = new Runtime(await load(sample)), { model, parts, rows } = runtime, { info } = model, depth = 1e-3 * mm;
  const { values, known, scale: legend } = mapsOf(runtime, null).find(({ name }) => name === `stiffness:${mm}`)!.values([]);
  known.forEach((is, i) => expect(is).toBe(Number(parts[i] === 'nonlinear' || parts[i] === 'linear')));
  for (const node of info.activeNodes) {
    const i = rows.get(node)!, inward = inwardAt([...info.outputPoints, ...info.fixedPoints], info.triangles, i);
    const force = row(model.force(node, scale(depth, inward)).force, 0);
    expect(values[i]! / (dot(force, inward) / depth)).toBeCloseTo(1, 9);
  }
  const probed = values.filter((_, i) => parts[i] === 'nonlinear');
  const { low, high, note, unit } = legend;
  expect([low, high, unit]).toEqual([Math.min(...probed), Math.max(...probed), 'N/m']);
  expect(note!.match(/: ([\d.]+) to ([\d.]+) N/)!.slice(1).map(Number)).toEqual([low, high].map((x) => Number(x.toPrecision(3))));
});
