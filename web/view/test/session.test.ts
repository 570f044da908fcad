// What the page computes without a page: tools, maps and the state in the address.
import { describe, expect, test } from 'vitest';
import type { Model } from '../../runtime/src/index.js';
import { block, bodyText, load, sample } from '../../runtime/test/setup.js';
import { add, norm, scale, sub, type V3 } from '../../shared/src/vectors.js';
import { Runtime } from '../src/answers.js';
import { mapsOf, onSurface } from '../src/maps.js';
import { nearestRay, pageDataOf } from '../src/page_data.js';
import { placeAt } from '../src/places.js';
import { joined } from '../src/plot.js';
import { forcesAlong } from '../src/readouts.js';
import { Session, sphereTool } from '../src/session.js';
import { fragmentOf, initialState, stateOf } from '../src/state.js';

const empty = pageDataOf('{}');
const session = async () => new Session(new Runtime(await load(sample)), empty, initialState());
const tool = (node: number, displacement: V3) => ({ place: placeAt(node), displacement });

describe('session', () => {
  test('tools that are set again at their places stay the same tools', async () => {
    const s = await session(), node = s.runtime.model.info.activeNodes[0]!;
    s.setTools([tool(node, [0.002, 0, 0])]);
    s.update();
    const number = s.numberOf(0);
    s.setTools([tool(node, [0.002, 0.003, 0])]);
    s.update();
    expect(s.numberOf(0)).toBe(number);
    expect(s.state.tools[0]!.displacement).toEqual([0.002, 0.003, 0]);
  });
  test('a place between nodes moves by the mean of its nodes, and a held node as its tool', async () => {
    const { runtime } = await session(), { activeNodes, triangles, outputNodes } = runtime.model.info, node = activeNodes[0]!;
    runtime.answer([tool(node, [0.002, 0.001, 0])]);
    runtime.displacementAt(placeAt(node)).forEach((u, k) => expect(u).toBeCloseTo([0.002, 0.001, 0][k]!, 12));
    const t = Array.from({ length: triangles.length / 3 }, (_, i) => triangles.slice(3 * i, 3 * i + 3))
      .find((corners) => corners.every((c) => c < outputNodes.length))!;
    const nodes = [...t].map((c) => outputNodes[c]!), weights = [0.2, 0.3, 0.5];
    const mean = [0, 1, 2].map((k) => nodes.reduce((sum, n, i) => sum + weights[i]! * runtime.displacement(n)[k]!, 0));
    runtime.displacementAt({ nodes, weights }).forEach((u, k) => expect(u).toBeCloseTo(mean[k]!, 12));
  });
  test('displacements stay within twice the trained depth', async () => {
    const s = await session(), node = s.runtime.model.info.activeNodes[0]!;
    s.setTools([tool(node, [1, 0, 0])]);
    expect(norm(s.state.tools[0]!.displacement)).toBeCloseTo(s.limit, 12);
  });
  test('fields are unknown under a sphere that touches, and 0 under one that does not', async () => {
    const s = await session();
    s.setMode('sphere');
    s.update();
    expect(s.mapTools).toEqual([]);
    // The first one lies at the border of the trained part, where a sphere does not touch.
    const place = placeAt(s.runtime.model.info.activeNodes[1]!), normal = s.normalAt(place), { radius } = s.state.sphere;
    s.putSphere(s.restPoint(place), normal);
    expect(s.mapTools).toEqual([]);
    s.move(sphereTool, add(s.restPoint(place), scale(0.9 * radius, normal)));
    s.update();
    expect(s.answer.touches[0]?.inContact).toBe(true);
    expect(s.mapTools).toBeNull();
    // No model of the tests has fields: one is added to its description.
    const { model } = s.runtime, info = { ...model.info, fields: [{ name: 'von-mises', unit: 'Pa' }] };
    const fielded = Object.create(s.runtime, { model: { value: Object.create(model, { info: { value: info } }) as Model } }) as Runtime;
    const map = mapsOf(fielded, null, () => 0.001).find(({ name }) => name === 'field:von-mises')!;
    expect(Math.max(...map.values(s.mapTools).known)).toBe(0);
    expect(Math.min(...map.values([]).known)).toBe(1);
  });
  test('maps keep the values of nodes on the surface', async () => {
    const s = await session(), map = s.maps.find(({ name }) => name === 'palpation')!.values([]);
    expect(Math.max(...map.values)).toBeLessThanOrEqual(map.scale.high);
    const drawn = onSurface(s.runtime.surface(0), map);
    map.values.forEach((value, i) => {
      if (map.known[i] === 1) expect(Math.abs(drawn.values[i]! - value)).toBeLessThan(1e-6 * map.scale.high); // single precision
    });
  });
});

test('a body answers for all tools, goes on until it rests, and curves do not disturb it', async () => {
  const runtime = new Runtime(await load(block), new TextDecoder().decode(bodyText())), s = new Session(runtime, empty, initialState());
  s.setTools([tool(26, [0.002, 0, -0.006]), tool(48, [0, 0, 0.004])]);
  s.update();
  expect(s.restless).toBe(true);
  let pictures = 1;
  for (; s.restless; ++pictures) s.update();
  expect(pictures).toBeLessThan(20);
  expect(s.problem).toBeNull();
  expect(s.answer.warnings).toEqual([]);
  expect(s.answer.bound).toBeGreaterThan(0);
  const { forces } = s.answer, [a, b] = s.state.tools, curve = runtime.forceOf(b!, [a!]);
  expect(norm(sub(curve([0, 0, 0.004]), forces[1]!))).toBeLessThan(1e-5 * norm(forces[1]!));
  s.update();
  // A body comes closer to rest with every call.
  s.answer.forces.forEach((force, i) => expect(norm(sub(force, forces[i]!))).toBeLessThan(1e-9 * norm(forces[i]!)));
  s.letGoAll();
  s.update();
  expect(Math.max(...runtime.field.map(Math.abs))).toBe(0);
  s.setTools([tool(26, [0, 0, -0.001])]);
  s.update();
  expect(norm(sub(s.answer.forces[0]!, runtime.model.force(26, [0, 0, -0.001]).force as unknown as V3))).toBeGreaterThan(0);
  s.setMode('sphere');
  const place = placeAt(37), normal = s.normalAt(place), { radius } = s.state.sphere;
  s.putSphere(s.restPoint(place), normal);
  for (let i = 0; i < 20; ++i) {
    s.move(sphereTool, add(s.restPoint(place), scale(radius - 1e-4 * i, normal)));
    s.update();
  }
  expect(norm(s.answer.forces[0]!)).toBeGreaterThan(0.01);
});

describe('the state in the address', () => {
  test('is read as it was written', () => {
    const state = { ...initialState(), map: 'palpation', tools: [tool(7, [0.001, -0.002, 0])], most: 2, level: 1,
      camera: { target: [0, 0.1, 0] as V3, distance: 0.5, azimuth: 1, elevation: 0.2 } };
    expect(stateOf(fragmentOf(state))).toEqual(state);
  });
  test.each(['', '#state=', '#state=%%', `#state=${btoa('null')}`, `#state=${btoa('{"most":9,"subdivision":1.5,"tools":[{}],"sphere":{"radius":-1}}')}`])(
    '%s gives the first state', (fragment) => expect(stateOf(fragment)).toEqual(initialState()));
});

test('curves share their depths, and have no value where they were not asked', () => {
  expect(joined([{ x: [0, 2], y: [5, 6] }, { x: [1], y: [7] }])).toEqual([[0, 1, 2], [5, null, 6], [null, 7, null]]);
});

test('the model is drawn along the stored direction, of whatever length, and not along the drag', () => {
  const at = (d: V3): V3 => [d[0], 4 * d[1], 0];
  expect(forcesAlong(at, [0, 2, 0], [0, 0.5, 1])).toEqual([0, 2, 4]);
  expect(forcesAlong(at, [3, 0, 0], [0, 0.5, 1])).toEqual([0, 0.5, 1]);
});

test('the stored ray that is nearest in direction is found', () => {
  const { rays } = pageDataOf('{"rays":[{"node":2,"direction":[1,0,0],"depth_m":[],"force_N":[]},{"node":2,"direction":[0,0,1],"depth_m":[],"force_N":[]}]}');
  expect(nearestRay(rays, 2, [0, 1, 1])!.angle).toBeCloseTo(Math.PI / 4, 12);
  expect(nearestRay(rays, 1, [0, 1, 1])).toBeNull();
});
