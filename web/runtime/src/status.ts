// Statuses of the C interface (phynness.h).

export const warnings = { outside: 1, incomplete: 2, unsettled: 4, near: 8 } as const;
export type Warning = keyof typeof warnings;

/** Status of what a model does not define. */
export const undefinedHere = -7;
/** A bound at least as large is none. */
export const noBound = 1e300;

/** Of the statuses -1, -2, ... */
const errorNames = [
  'ARGUMENT', 'NOT_ACTIVE', 'NOT_FINITE', 'BUFFER', 'TOOLS', 'ROUND_TOOLS', 'UNDEFINED', 'CLOCK', 'NOT_A_MODEL', 'VERSION', 'TRUNCATED',
  'CHECKSUM', 'SYNTAX', 'RANGE', 'FAMILY', 'OVERLAP', 'TOO_LARGE', 'GEOMETRY', 'TOO_MANY_TOOLS',
  'IMAGE_OF_FLOATS', 'IMAGE_OF_DOUBLES',
];

/** A refused call of the runtime. */
export class PhynnessError extends Error {
  override readonly name = 'PhynnessError';
  constructor(
    /** PHN_ERROR_* as a number below 0 */
    readonly status: number,
    /** meaning of the status, from phn_status_message */
    readonly reason: string,
    /** what was called */
    call: string,
    /** position of the first error in a refused model.txt, counted from 1 */
    readonly wrongByte?: number,
  ) {
    super(`${call}: ${reason}${wrongByte ? ` (byte ${wrongByte})` : ''}`);
  }
  /** for example "PHN_ERROR_CHECKSUM" */
  get statusName(): string {
    const name = errorNames[-1 - this.status];
    return name ? `PHN_ERROR_${name}` : `status ${this.status}`;
  }
}

const none: readonly Warning[] = Object.freeze([]);

/** The warnings of a status >= 0. */
export function warningsOf(status: number): readonly Warning[] {
  if (status <= 0) return none;
  return (Object.keys(warnings) as Warning[]).filter((name) => (status & warnings[name]) !== 0);
}
