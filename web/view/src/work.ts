// Work of a tool along its path.
import { add, dot, norm, scale, sub, zero, type V3 } from '../../shared/src/vectors.js';

export type ForceAt = (d: V3) => V3;

/** Nodes and weights of the Gauss rule with three points on 0 ... 1. */
const rule: readonly (readonly [number, number])[] = [
  [0.5 - Math.sqrt(0.15), 5 / 18],
  [0.5, 8 / 18],
  [0.5 + Math.sqrt(0.15), 5 / 18],
];

/** Work [J] of the force that holds the body, along the straight line from `from` to `to` [m], in parts of at most `step`. */
export function workAlong(force: ForceAt, from: V3, to: V3, step: number): number {
  const line = sub(to, from), parts = Math.min(64, Math.max(1, Math.ceil(norm(line) / step)));
  let work = 0;
  for (let part = 0; part < parts; ++part)
    for (const [t, weight] of rule) work += (weight / parts) * dot(force(add(from, scale((part + t) / parts, line))), line);
  return work;
}

/** Work since a tool was at rest. The path is closed by the straight line back to rest: what then remains was gained or
 * lost by the model, and is 0 if its force is the gradient of an energy. */
export class PathWork {
  private work = 0;
  private last: V3 = zero;

  constructor(
    private readonly force: ForceAt,
    private readonly step: number,
  ) {}

  moveTo(d: V3): void {
    if (d[0] === this.last[0] && d[1] === this.last[1] && d[2] === this.last[2]) return;
    this.work += workAlong(this.force, this.last, d, this.step);
    this.last = d;
  }
  /** Done by the hand until now [J]. */
  get done(): number {
    return this.work;
  }
  /** Of the path that is closed by a straight line [J]. */
  get closed(): number {
    return this.work - workAlong(this.force, zero, this.last, this.step / 2);
  }
}
