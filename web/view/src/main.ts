// Starts the page with the model that it contains.
import { loader, PhynnessError } from '../../runtime/src/index.js';
import { project } from '../../shared/src/camera.js';
import { plain } from '../../shared/src/numbers.js';
import type { V3 } from '../../shared/src/vectors.js';
import wasm from 'phynness.wasm';
import { Runtime } from './answers.js';
import { byId, setText } from './dom.js';
import { pageDataOf } from './page_data.js';
import { placeAt } from './places.js';
import { Session } from './session.js';
import { View } from './view.js';

async function start(): Promise<void> {
  if (document.createElement('canvas').getContext('webgl2') === null)
    throw new Error('this browser has no WebGL 2, or it is turned off; turn on hardware acceleration, or open the page in another browser');
  const data = pageDataOf(byId('phynness-data', HTMLScriptElement).textContent ?? '');
  const model = await loader(() => WebAssembly.compile(wasm))(data.model);
  const title = plain(model.info.title) || 'phynness';
  setText(byId('title', HTMLElement), title);
  document.title = title;
  expose(new View(new Session(new Runtime(model, data.body), data)));
}

/** For scripts in the console of the browser, and for tests. */
function expose(view: View): void {
  const { session } = view;
  const now = () => {
    view.changed(true);
    view.draw();
  };
  Object.assign(globalThis, {
    phynness: {
      session,
      view,
      /** Holds nodes: [{node, displacement}, ...] */
      hold: (tools: { node: number; displacement: V3 }[]) => {
        session.setMost(tools.length > 1 ? 2 : session.most);
        session.tools = tools.map(({ node, displacement }) => ({ place: placeAt(node), at: displacement }));
        now();
      },
      set: (settings: Partial<Session>) => {
        Object.assign(session, settings);
        now();
      },
      /** Pixel of the last tool. */
      seen: () => project(view.camera, view.size, view.seen(session.tools.at(-1)!)),
      /** Pixel of a node at rest, as it is drawn. */
      project: (node: number) => project(view.camera, view.size, view.seen({ place: placeAt(node), at: [0, 0, 0] })),
    },
  });
}

start().catch((error: unknown) => {
  const reason = error instanceof Error ? error.message : String(error);
  const remedy = error instanceof PhynnessError || error instanceof WebAssembly.CompileError ? ' Write the page again with phynness view.' : '';
  const problem = byId('problem', HTMLElement);
  document.body.dataset['mode'] = 'failed';
  problem.hidden = false;
  setText(problem, `This page cannot start: ${reason}.${remedy}`);
});
