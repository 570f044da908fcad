// The shared modes of a model.txt of family modal (formats/model.md), which the C interface does not give.

/** A hexadecimal float such as 1.8p+1. */
export function hexFloat(word: string): number {
  const match = /^(-?)([01])(?:\.([0-9a-f]{1,13}))?p([+-]\d{1,4})$/.exec(word);
  if (!match) throw new RangeError(`${word} is not a hexadecimal float`);
  const [, sign, whole, digits = '', exponent] = match;
  const size = (Number(whole) + parseInt(digits || '0', 16) / 16 ** digits.length) * 2 ** Number(exponent);
  return sign === '-' ? -size : size;
}

/** Displacements [m] of all output nodes in the first `most` shared modes; none in other families. */
export function sharedModes(text: string, nOutput: number, most: number): Float64Array[] {
  const begin = text.indexOf('\nshared_modes ');
  if (begin < 0 || most <= 0) return [];
  const head = text.indexOf('\nmodes ', begin), rows = 3 * nOutput;
  const scales = text.slice(head + 7, text.indexOf('\n', head + 1)).split(' ').slice(0, most).map(hexFloat);
  const modes = scales.map(() => new Float64Array(rows));
  let at = text.indexOf('\n', head + 1) + 1;
  for (let row = 0; row < rows; ++row) {
    const end = text.indexOf('\n', at), numbers = text.slice(at, end).split(' ');
    modes.forEach((mode, k) => (mode[row] = scales[k]! * Number(numbers[k])));
    at = end + 1;
  }
  return modes;
}
