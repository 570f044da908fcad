// The trust figure as a colour and a word.
import type { Warning } from '../../runtime/src/index.js';
import type { TrustFigure } from './answers.js';

export interface Verdict {
  /** class of the colour */
  readonly kind: 'good' | 'fair' | 'beyond' | 'unknown';
  readonly word: string;
  readonly reason: string;
}

/** Smallest noticeable difference of forces. */
const noticeable = 0.1;

/** @param bound  of the error, over the force; null: not known. @param ofBody  not of the model */
export function verdictOf(warnings: readonly Warning[], trust: TrustFigure | null, bound: number | null, ofBody = false): Verdict {
  if (warnings.includes('unsettled'))
    return { kind: 'beyond', word: 'unsettled', reason: `the tools ${ofBody ? 'moved faster than the body settles, or ' : ''}are too close together to hold all points` };
  if (warnings.includes('outside')) return { kind: 'beyond', word: 'beyond data', reason: 'deeper or stronger than the training data, or beside fixed nodes' };
  if (trust && trust.relative > 1) return { kind: 'beyond', word: 'beyond data', reason: 'far from the training data' };
  if (bound !== null && bound > noticeable)
    return { kind: 'fair', word: 'inexact', reason: 'the error of the force may exceed a tenth of it' };
  if (warnings.includes('incomplete'))
    return { kind: 'fair', word: 'incomplete', reason: 'some directions of this node were not trained to the full depth' };
  if (!trust) return { kind: 'unknown', word: 'inside range', reason: `no warning${ofBody ? '' : '; the trust figure exists for one tool at a node'}` };
  if (trust.relative > 0.5) return { kind: 'fair', word: 'between data', reason: 'inside the trained range, between training data' };
  return { kind: 'good', word: 'close to data', reason: 'close to training data' };
}
