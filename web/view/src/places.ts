// Places of the surface that a tool can hold: a node, or a point between the nodes of a triangle.
import type { Place } from '../../runtime/src/index.js';
import { add, scale, zero, type V3 } from '../../shared/src/vectors.js';

export const placeAt = (node: number): Place => ({ nodes: [node], weights: [1] });

/** The node of a place that is a node, otherwise null. */
export const nodeOf = (place: Place): number | null => (place.nodes.length === 1 ? place.nodes[0]! : null);

export function nameOf(place: Place): string {
  const node = nodeOf(place);
  if (node !== null) return `node ${node}`;
  return `point between nodes ${place.nodes.slice(0, -1).join(', ')} and ${place.nodes.at(-1)}`;
}

/** A quantity at a place, from its values at nodes. */
export function meanAt({ nodes, weights }: Place, valueAt: (node: number) => V3): V3 {
  return nodes.reduce<V3>((sum, node, i) => add(sum, scale(weights[i]!, valueAt(node))), zero);
}
