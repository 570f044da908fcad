// What the tests get from the build (environment variables that CMake sets).
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Model } from '../runtime/src/model.js';

function given(name: string): string {
  const value = process.env[name];
  if (!value) throw new Error(`${name} is not set; ctest -R web sets it`);
  return value;
}

export const built = {
  phynness: given('PHYNNESS'),
  wasm: given('PHYNNESS_WASM'),
  package: given('PHYNNESS_PACKAGE'),
  models: given('PHYNNESS_MODELS'),
};

const module = new WebAssembly.Module(new Uint8Array(readFileSync(built.wasm)));
export const textOf = (folder: string) => new Uint8Array(readFileSync(join(folder, 'model.txt')));
export const load = (folder: string) => Model.create(module, textOf(folder));
export const loadText = (text: Uint8Array) => Model.create(module, text);
/** A block of springs, and its reduced body. */
export const block = join(built.models, 'block');
export const bodyText = () => new Uint8Array(readFileSync(join(block, 'body.txt')));
export const sample = join(built.models, 'sample');

export interface Golden {
  node: number;
  displacement: number[];
  status: number;
  force: number[];
  output: number;
  deformation: number[];
}
export function golden(folder: string): Golden[] {
  const work = mkdtempSync(join(tmpdir(), 'phynness-web-'));
  const json = join(work, 'golden.json');
  execFileSync(built.phynness, ['export', folder, '-o', join(work, 'out'), '--float', '--golden', '200', '--json', json]);
  return (JSON.parse(readFileSync(json, 'utf8')) as { golden: Golden[] }).golden;
}

/** Largest difference of two lists of numbers, as a fraction of the largest number. */
export function difference(expected: ArrayLike<number>, got: ArrayLike<number>): number {
  if (expected.length !== got.length) return Infinity;
  let largest = 0, off = 0;
  for (let i = 0; i < expected.length; ++i) {
    const e = expected[i]!, g = got[i]!;
    if (!Number.isFinite(g)) return Infinity;
    largest = Math.max(largest, Math.abs(e));
    off = Math.max(off, Math.abs(e - g));
  }
  return largest > 0 ? off / largest : off;
}
