// What can be seen and is held, as the fragment of the page's address: #state=base64url(JSON).
import type { Camera } from '../../shared/src/camera.js';
import type { V3 } from '../../shared/src/vectors.js';
import { isPlace, type Place } from './places.js';

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
  edges: boolean;
  nodes: boolean;
  sphere: { center: V3 | null; radius: number; friction: number; grasp: boolean };
}

export function initialState(): State {
  return {
    camera: null, mode: 'hold', tools: [], most: 1, keep: true, atNodes: true, subdivision: 2, level: null, map: 'none',
    palpationDepth: 0, components: false, edges: false, nodes: true,
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

/** The state of a fragment; the first state if a value is of another type or out of range. */
export function stateOf(fragment: string): State {
  const first = initialState();
  if (!fragment.startsWith(prefix)) return first;
  try {
    const binary = atob(fragment.slice(prefix.length).replaceAll('-', '+').replaceAll('_', '/'));
    const given = JSON.parse(new TextDecoder().decode(Uint8Array.from(binary, (c) => c.charCodeAt(0)))) as Partial<State>;
    const state: State = { ...first, ...given, sphere: { ...first.sphere, ...given.sphere } };
    return isValid(state) ? state : first;
  } catch {
    return first;
  }
}

function isValid({ camera, mode, tools, most, subdivision, level, map, palpationDepth, sphere, ...flags }: State): boolean {
  const within = (x: unknown, low: number, high: number) => typeof x === 'number' && x >= low && x <= high;
  const whole = (x: unknown, low: number, high: number) => Number.isInteger(x) && within(x, low, high);
  const isPoint = (x: unknown) => Array.isArray(x) && x.length === 3 && x.every((n) => within(n, -1e3, 1e3));
  return (camera === null || (isPoint(camera.target) && within(camera.distance, 1e-6, 1e3) && within(camera.azimuth, -10, 10)
      && within(camera.elevation, -1.56, 1.56)))
    && (mode === 'hold' || mode === 'sphere') && whole(most, 1, 2) && tools.length <= most
    && tools.every(({ place, displacement }) => isPlace(place) && isPoint(displacement))
    && whole(subdivision, 0, 3) && (level === null || whole(level, 0, 100)) && typeof map === 'string' && within(palpationDepth, 0, 1)
    && (sphere.center === null || isPoint(sphere.center)) && within(sphere.radius, 0, 1) && within(sphere.friction, 0, 10)
    && [sphere.grasp, ...Object.values(flags)].every((flag) => typeof flag === 'boolean');
}
