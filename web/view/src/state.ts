// What can be seen and is held, as the fragment of the page's address: #state=base64url(JSON).
import type { Camera } from '../../shared/src/camera.js';
import type { V3 } from '../../shared/src/vectors.js';
import { placeOf, type Place } from './places.js';

export interface HeldTool {
  readonly place: Place;
  /** of the held point [m] */
  displacement: V3;
}

export interface State {
  camera: Camera | null;
  /** hold: tools hold points of the surface; sphere: a sphere touches it */
  mode: 'hold' | 'sphere';
  tools: HeldTool[];
  /** how many tools at most, 1 or 2 */
  most: number;
  /** tools stay where they were when the pointer is released */
  keep: boolean;
  /** tools hold the nearest node, not the point under the pointer */
  atNodes: boolean;
  /** the surface in the picture is subdivided so many times, 0 ... 3 */
  subdivision: number;
  /** index of the model's levels; null: the full model */
  level: number | null;
  /** name of a map, or 'none' */
  map: string;
  /** depth of the palpation map [m]; 0: a default of the model */
  palpationDepth: number;
  components: boolean;
  ellipsoid: boolean;
  edges: boolean;
  nodes: boolean;
  sphere: { center: V3 | null; radius: number; friction: number; grasp: boolean };
}

export function initialState(): State {
  return {
    camera: null, mode: 'hold', tools: [], most: 1, keep: true, atNodes: true, subdivision: 2, level: null, map: 'none',
    palpationDepth: 0, components: false, ellipsoid: false, edges: false, nodes: true,
    sphere: { center: null, radius: 0, friction: 0.3, grasp: false },
  };
}

const prefix = '#state=';

export function fragmentOf(state: State): string {
  const bytes = new TextEncoder().encode(JSON.stringify(state, (_, x: unknown) => (typeof x === 'number' ? Number(x.toPrecision(9)) : x)));
  let binary = '';
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return prefix + btoa(binary).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

/** The state of a fragment; values of another type or out of range keep their defaults. */
export function stateOf(fragment: string): State {
  const state = initialState();
  if (!fragment.startsWith(prefix)) return state;
  let given: unknown;
  try {
    const binary = atob(fragment.slice(prefix.length).replaceAll('-', '+').replaceAll('_', '/'));
    given = JSON.parse(new TextDecoder().decode(Uint8Array.from(binary, (c) => c.charCodeAt(0))));
  } catch {
    return state;
  }
  return isObject(given) ? filled(state, given) : state;
}

type Loose = Record<string, unknown>;
const isObject = (x: unknown): x is Loose => typeof x === 'object' && x !== null && !Array.isArray(x);
const within = (x: unknown, low: number, high: number, otherwise: number): number =>
  typeof x === 'number' && x >= low && x <= high ? x : otherwise;
const whole = (x: unknown, low: number, high: number, otherwise: number): number =>
  Number.isInteger(x) ? within(x, low, high, otherwise) : otherwise;
const flag = (x: unknown, otherwise: boolean): boolean => (typeof x === 'boolean' ? x : otherwise);
const point = (x: unknown): V3 | null =>
  Array.isArray(x) && x.length === 3 && x.every((n) => typeof n === 'number' && Math.abs(n) < 1e3) ? (x as unknown as V3) : null;

function filled(state: State, given: Loose): State {
  const sphere = isObject(given['sphere']) ? given['sphere'] : {};
  const tools = Array.isArray(given['tools']) ? given['tools'].slice(0, 2).map(toolOf).filter((tool) => tool !== null) : [];
  return {
    camera: cameraOf(given['camera']),
    mode: given['mode'] === 'sphere' ? 'sphere' : 'hold',
    tools,
    most: Math.max(tools.length, whole(given['most'], 1, 2, state.most)),
    keep: flag(given['keep'], state.keep),
    atNodes: flag(given['atNodes'], state.atNodes),
    subdivision: whole(given['subdivision'], 0, 3, state.subdivision),
    level: given['level'] === null ? null : whole(given['level'], 0, 100, -1) < 0 ? null : (given['level'] as number),
    map: typeof given['map'] === 'string' ? given['map'].slice(0, 100) : state.map,
    palpationDepth: within(given['palpationDepth'], 0, 1, state.palpationDepth),
    components: flag(given['components'], state.components),
    ellipsoid: flag(given['ellipsoid'], state.ellipsoid),
    edges: flag(given['edges'], state.edges),
    nodes: flag(given['nodes'], state.nodes),
    sphere: {
      center: point(sphere['center']),
      radius: within(sphere['radius'], 0, 1, state.sphere.radius),
      friction: within(sphere['friction'], 0, 10, state.sphere.friction),
      grasp: flag(sphere['grasp'], state.sphere.grasp),
    },
  };
}

function toolOf(x: unknown): HeldTool | null {
  if (!isObject(x)) return null;
  const place = placeOf(x['place']), displacement = point(x['displacement']);
  return place && displacement ? { place, displacement } : null;
}

function cameraOf(x: unknown): Camera | null {
  if (!isObject(x)) return null;
  const target = point(x['target']), distance = within(x['distance'], 1e-6, 1e3, 0);
  const azimuth = within(x['azimuth'], -10, 10, NaN), elevation = within(x['elevation'], -1.56, 1.56, NaN);
  return target && distance > 0 && azimuth === azimuth && elevation === elevation ? { target, distance, azimuth, elevation } : null;
}
