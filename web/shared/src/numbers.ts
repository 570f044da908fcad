// Numbers with units as people read them, ticks of scales, and texts of unknown origin.

/** A number with so many significant digits, without an exponent where that is readable. */
export function significant(x: number, digits: number): string {
  if (!Number.isFinite(x)) return '–';
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size < 1e-5 || size >= 1e7) return x.toExponential(digits - 1).replace('-', '−').replace('e−', 'e-').replace('e+', 'e');
  const before = Math.floor(Math.log10(size)) + 1;
  return Number(x.toPrecision(digits)).toFixed(Math.min(20, Math.max(0, digits - before))).replace('-', '−');
}

/** The unit in which a quantity is shown, and the factor from its SI unit. */
export function shown(unit: string, largest: number): { unit: string; factor: number } {
  const size = Math.abs(largest);
  if (unit === 'm') return { unit: 'mm', factor: 1e3 };
  if (unit === 'fraction' || unit === '') return { unit: '%', factor: 1e2 };
  if (unit === 'J') return size < 0.1 ? { unit: 'mJ', factor: 1e3 } : { unit, factor: 1 };
  if (unit === 'Pa' || unit === 'J/m3' || unit === 'J/m^3') {
    const symbol = unit === 'Pa' ? 'Pa' : 'J/m³';
    return size >= 1e3 ? { unit: `k${symbol}`, factor: 1e-3 } : { unit: symbol, factor: 1 };
  }
  return { unit, factor: 1 };
}

/** Multiples of 1, 2 or 5 times a power of ten between low and high, at most `most` + 1 of them. */
export function ticks(low: number, high: number, most = 5): number[] {
  const span = high - low;
  if (!(span > 0) || !Number.isFinite(span)) return [low];
  const power = 10 ** Math.floor(Math.log10(span / most));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => span / s <= most + 1e-9)!;
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

/** The largest 1, 2 or 5 times a power of ten that is not above x. */
export function roundedDown(x: number): number {
  if (!(x > 0) || !Number.isFinite(x)) return 0;
  const power = 10 ** Math.floor(Math.log10(x));
  const step = [5, 2, 1].find((f) => f * power <= x * (1 + 1e-12))!;
  return Number((step * power).toPrecision(3));
}

/** The smallest 1, 1.5, 2, 3, 5 or 7 times a power of ten that is not below x. */
export function roundedUp(x: number): number {
  if (!(x > 0) || !Number.isFinite(x)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  const step = [1, 1.5, 2, 3, 5, 7, 10].find((f) => f * power >= x * (1 - 1e-12))!;
  return Number((step * power).toPrecision(3));
}

/** A text in which every character can be seen, as of printable() in C++, others as their codes; cut at `most`. */
export function plain(text: string, most = 200): string {
  const visible = text.replace(/[\p{Cc}\p{Default_Ignorable_Code_Point}\u2028\u2029\ufff9-\ufffb]/gu, (c) =>
    c === '\n' || c === '\t' ? ' ' : `\\u{${c.codePointAt(0)!.toString(16)}}`);
  return visible.length > most ? `${visible.slice(0, most - 1)}…` : visible;
}
