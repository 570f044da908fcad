// Places of the surface that a tool can hold: a node, or a point between the nodes of a triangle.
import type { Tool } from '../../runtime/src/tool.js';
import type { V3 } from '../../shared/src/vectors.js';

export interface Place {
  readonly nodes: readonly number[];
  /** barycentric, >= 0, with the sum 1 */
  readonly weights: readonly number[];
}

export const placeAt = (node: number): Place => ({ nodes: [node], weights: [1] });

/** The node of a place that is a node, otherwise null. */
export const nodeOf = (place: Place): number | null => (place.nodes.length === 1 ? place.nodes[0]! : null);

export const samePlace = (a: Place, b: Place): boolean => JSON.stringify(a) === JSON.stringify(b);

export const toolOf = (place: Place, displacement: V3): Tool => ({ nodes: place.nodes, weights: place.weights, displacement });

export function nameOf(place: Place): string {
  const node = nodeOf(place);
  if (node !== null) return `node ${node}`;
  return `point between nodes ${place.nodes.slice(0, -1).join(', ')} and ${place.nodes.at(-1)}`;
}

/** The node with the largest weight. */
export function mainNode(place: Place): number {
  return place.nodes[place.weights.indexOf(Math.max(...place.weights))]!;
}

/** A place from data of unknown origin. */
export function placeOf(x: unknown): Place | null {
  if (typeof x !== 'object' || x === null) return null;
  const { nodes, weights } = x as Record<string, unknown>;
  const isNode = (n: unknown) => Number.isInteger(n) && (n as number) >= 0 && (n as number) < 2 ** 31;
  if (!Array.isArray(nodes) || !Array.isArray(weights)) return null;
  if (nodes.length < 1 || nodes.length > 3 || weights.length !== nodes.length || new Set(nodes).size !== nodes.length) return null;
  if (!nodes.every(isNode) || !weights.every((w) => typeof w === 'number' && w >= 0 && w <= 1)) return null;
  const sum = (weights as number[]).reduce((s, w) => s + w, 0);
  return Math.abs(sum - 1) < 1e-6 ? { nodes: nodes as number[], weights: weights as number[] } : null;
}
