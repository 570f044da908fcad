// What the commands write into a report (web/pages/include/phynness/pages/report.hpp).
export interface PageData {
  readonly title: string;
  readonly sections: readonly Section[];
}
export interface Section {
  /** empty: the section at the beginning */
  readonly title: string;
  readonly blocks: readonly Block[];
}
/** Each has one of these. */
export interface Block {
  readonly text?: string;
  readonly warning?: string;
  /** of less weight */
  readonly remark?: string;
  /** titles and sentences */
  readonly list?: readonly (readonly [string, string])[];
  /** the first row is the head */
  readonly table?: readonly (readonly Cell[])[];
  readonly charts?: readonly Chart[];
  readonly pictures?: readonly { readonly svg: string; readonly caption: string }[];
  readonly body?: BodyData;
  /** the title under which a table is folded */
  readonly folded?: string;
  /** of a table: its cells hold words, which are broken across lines */
  readonly words?: boolean;
}
/** A cell with a case shows this case on the body. */
export type Cell = string | { readonly text: string; readonly case: number };

export interface BodyCase {
  readonly node: number;
  /** index of the touched node among the points */
  readonly row: number;
  readonly displacement_m: readonly number[];
  /** fraction of the node's largest force */
  readonly force_error: number;
  /** of the output nodes, n x 3 [m] */
  readonly finite_elements_m: readonly number[];
  readonly model_m: readonly number[];
}
/** By place: mean error, a fraction, and of how many forces the predictor warns. */
export interface PointErrors {
  readonly name: string;
  readonly force_error: readonly number[];
  readonly flagged: readonly number[];
}
/** Tools between nodes: each place has three rows of points, their weights, and errors of each predictor. */
export interface BetweenNodes {
  readonly rows: readonly number[];
  readonly weights: readonly number[];
  readonly predictors: readonly PointErrors[];
}
export interface BodyData {
  /** output nodes, then fixed nodes, n x 3 [m] */
  readonly points_m: readonly number[];
  readonly n_output: number;
  readonly triangles: readonly number[];
  /** mean by output node, fractions */
  readonly displacement_error: readonly number[];
  readonly between_nodes: BetweenNodes | null;
  /** row of an active node and share of its probe volume that the model has not trained */
  readonly not_trained: readonly (readonly [number, number])[];
  readonly nodes: readonly { readonly node: number; readonly row: number; readonly force_error: number }[];
  readonly cases: readonly BodyCase[];
}

export interface Curve {
  readonly title: string;
  readonly mark: 'line' | 'dashes' | 'dotted' | 'points' | 'joined';
  /** index of the page's colours: 0 model, 1 linear predictor, 2 finite elements and text, 3 ... 7 others */
  readonly color: number;
  readonly x: readonly number[];
  readonly y: readonly number[];
}
export interface Chart {
  readonly title: string;
  readonly x: string;
  readonly y: string;
  readonly curves: readonly Curve[];
  readonly log_x?: boolean;
  readonly log_y?: boolean;
  /** of the vertical axis */
  readonly range?: readonly [number, number];
  readonly caption?: string;
}
