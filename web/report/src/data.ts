// What `phynness validate --report` writes into its page (validation/src/report/body_data.cpp, drawing/src/plots.cpp).
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
export interface BodyData {
  /** output nodes, then fixed nodes, n x 3 [m] */
  readonly points_m: readonly number[];
  readonly n_output: number;
  readonly triangles: readonly number[];
  /** mean by output node, fractions */
  readonly displacement_error: readonly number[];
  /** row of an active node and share of its probe volume that the model has not trained */
  readonly not_trained: readonly (readonly [number, number])[];
  readonly nodes: readonly { readonly node: number; readonly row: number; readonly force_error: number }[];
  readonly cases: readonly BodyCase[];
}

export interface Chart {
  readonly title: string;
  readonly x: string;
  readonly y: string;
  readonly log_x: boolean;
  readonly log_y: boolean;
  /** of the vertical axis */
  readonly range?: readonly [number, number];
  readonly curves: readonly {
    readonly title: string;
    readonly mark: 'line' | 'dashes' | 'dotted' | 'points' | 'joined';
    /** index of the page's colours */
    readonly color: number;
    readonly x: readonly number[];
    readonly y: readonly number[];
  }[];
}
