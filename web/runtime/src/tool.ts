// Tools: points of the surface that are held.
import { bytesOf, type Engine } from './engine.js';

export type Vector = ArrayLike<number>;

/** A place of the surface: up to three nodes of one triangle with weights that add up to 1. */
export interface Place {
  readonly nodes: readonly number[];
  readonly weights: readonly number[];
}
/** A tool that holds a place. */
export interface Tool extends Place {
  /** of the held place [m] */
  readonly displacement: Vector;
}

/** A tool at a node. */
export function toolAt(node: number, displacement: Vector): Tool {
  return { nodes: [node], weights: [1], displacement };
}

export function putVector(engine: Engine, at: number, v: Vector, what: string): void {
  if (v.length !== 3) throw new RangeError(`${what} has ${v.length} numbers instead of 3`);
  engine.reals(at, 3).set(v);
}

export function putTool(engine: Engine, at: number, tool: Tool): void {
  const n = tool.nodes.length;
  if (n < 1 || n > 3 || tool.weights.length !== n)
    throw new RangeError(`a tool has 1 to 3 nodes and as many weights, not ${n} and ${tool.weights.length}`);
  const nodes = engine.integers(at + bytesOf('phn_tool.nodes'), 3);
  const weights = engine.reals(at + bytesOf('phn_tool.weights'), 3);
  nodes.fill(-1);
  engine.integers(at + bytesOf('phn_tool.reserved'), 2).fill(0);
  weights.fill(0);
  tool.nodes.forEach((node, k) => {
    if (!Number.isInteger(node) || node < 0 || node > 0x7fffffff) throw new RangeError(`${node} is not a node`);
    nodes[k] = node;
  });
  weights.set(tool.weights);
  putVector(engine, at + bytesOf('phn_tool.displacement'), tool.displacement, 'the displacement');
}

export function toolFrom(engine: Engine, at: number): Tool {
  const nodes = [...engine.integers(at + bytesOf('phn_tool.nodes'), 3)];
  const weights = [...engine.reals(at + bytesOf('phn_tool.weights'), 3)];
  const n = nodes.findIndex((node) => node < 0);
  const count = n < 0 ? 3 : n;
  return {
    nodes: nodes.slice(0, count),
    weights: weights.slice(0, count),
    displacement: engine.reals(at + bytesOf('phn_tool.displacement'), 3).slice(),
  };
}
