// Statuses of the C interface (phynness.h).

export const warnings = { outside: 1, incomplete: 2, unsettled: 4 } as const;
export type Warning = keyof typeof warnings;

/** Status of what a model does not define. */
export const undefinedHere = -7;
/** A bound at least as large is none. */
export const noBound = 1e300;

const errorNames: Readonly<Record<number, string>> = {
  [-1]: 'PHN_ERROR_ARGUMENT',
  [-2]: 'PHN_ERROR_NOT_ACTIVE',
  [-3]: 'PHN_ERROR_NOT_FINITE',
  [-4]: 'PHN_ERROR_BUFFER',
  [-5]: 'PHN_ERROR_TOOLS',
  [-6]: 'PHN_ERROR_SAME_NODE',
  [-7]: 'PHN_ERROR_UNDEFINED',
  [-8]: 'PHN_ERROR_CLOCK',
  [-9]: 'PHN_ERROR_NOT_A_MODEL',
  [-10]: 'PHN_ERROR_VERSION',
  [-11]: 'PHN_ERROR_TRUNCATED',
  [-12]: 'PHN_ERROR_CHECKSUM',
  [-13]: 'PHN_ERROR_SYNTAX',
  [-14]: 'PHN_ERROR_RANGE',
  [-15]: 'PHN_ERROR_FAMILY',
  [-16]: 'PHN_ERROR_OVERLAP',
  [-17]: 'PHN_ERROR_TOO_LARGE',
  [-18]: 'PHN_ERROR_GEOMETRY',
  [-19]: 'PHN_ERROR_TOO_MANY_TOOLS',
  [-20]: 'PHN_ERROR_ROUND_TOOLS',
};

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
    return errorNames[this.status] ?? `status ${this.status}`;
  }
}

const none: readonly Warning[] = Object.freeze([]);

/** The warnings of a status >= 0. */
export function warningsOf(status: number): readonly Warning[] {
  if (status <= 0) return none;
  return (Object.keys(warnings) as Warning[]).filter((name) => (status & warnings[name]) !== 0);
}
