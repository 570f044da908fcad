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

/** Whether data of unknown origin are a place. */
export function isPlace({ nodes, weights }: Place): boolean {
  return nodes.length >= 1 && nodes.length <= 3 && weights.length === nodes.length && new Set(nodes).size === nodes.length
    && nodes.every((n) => Number.isInteger(n) && n >= 0 && n < 2 ** 31) && weights.every((w) => w >= 0 && w <= 1)
    && Math.abs(weights.reduce((sum, w) => sum + w, 0) - 1) < 1e-6;
}
