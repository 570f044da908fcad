// Starts the page: loads the model that it contains, or one that is dropped on it.
import '../../shared/src/locale.js';
import { loader, PhynnessError, type Model } from '../../runtime/src/index.js';
import { metresPerPixel, project } from '../../shared/src/camera.js';
import { fileName, plain } from '../../shared/src/numbers.js';
import { add, type V3 } from '../../shared/src/vectors.js';
import wasm from 'phynness.wasm';
import { Runtime } from './answers.js';
import { byId, download, setText } from './dom.js';
import { glbOf, pngOf } from './exports.js';
import { pageDataOf, type PageData } from './page_data.js';
import { placeAt } from './places.js';
import { Session } from './session.js';
import { initialState, stateOf, type State } from './state.js';
import { View } from './view.js';

const modelFromText = loader(() => WebAssembly.compile(wasm));

class Page {
  private view: View | null = null;
  private text = '';
  /** the data that belongs to the model in view */
  private shown: PageData;

  constructor(private readonly data: PageData) {
    this.shown = data;
    const file = byId('model-file', HTMLInputElement);
    byId('open-model', HTMLButtonElement).addEventListener('click', () => file.click());
    file.addEventListener('change', () => {
      if (file.files?.[0]) this.take(file.files[0]);
      file.value = '';
    });
    this.listenToDrops();
    byId('save-png', HTMLButtonElement).addEventListener('click', () => void this.savePng());
    byId('save-glb', HTMLButtonElement).addEventListener('click', () => void this.saveGlb());
  }

  async start(): Promise<void> {
    if (document.createElement('canvas').getContext('webgl2') === null)
      return this.refuse('This browser cannot draw the body: WebGL 2 is missing or turned off. Turn on hardware acceleration in its settings, or open the page in another browser.');
    if (this.data.model === null) return this.refuse('This page contains no model. Drop a model.txt here, or open one.');
    const state = stateOf(location.hash);
    if (location.hash === '' && this.data.body !== null) state.atNodes = false;
    await this.open(this.data.model, this.data, state);
    window.addEventListener('hashchange', () => void this.open(this.text, this.shown, stateOf(location.hash)));
  }
  /** @param bytes  of the file, if they are no valid text; errors name a byte of them */
  private async open(text: string, data: PageData, state: State, bytes?: Uint8Array): Promise<void> {
    let model: Model | null = null, runtime: Runtime;
    try {
      model = await modelFromText(bytes ?? text);
      if (model.info.triangles.length === 0) return this.refuse('This model has no triangles, and nothing can be drawn.');
      runtime = new Runtime(model, data.body);
    } catch (error) {
      if (!(error instanceof PhynnessError)) throw error;
      const file = model ? 'body.txt' : 'model.txt';
      const byte = error.wrongByte ? ` The first wrong byte is number ${error.wrongByte.toLocaleString('en')}.` : '';
      return this.refuse(`This ${file} is refused (${error.statusName}): ${error.reason}.${byte}`);
    }
    const before = this.view?.session;
    const session = new Session(runtime, data, state);
    byId('problem', HTMLElement).hidden = true;
    if (this.view) this.view.open(session);
    else this.view = new View(session);
    before?.runtime.dispose();
    this.text = text;
    this.shown = data;
    const title = plain(model.info.title) || 'phynness';
    setText(byId('title', HTMLElement), title);
    setText(byId('about', HTMLElement), data.scene_title === model.info.title ? '' : plain(data.scene_title));
    document.title = title;
    this.view.draw();
    this.expose(this.view);
  }
  private refuse(reason: string): void {
    const problem = byId('problem', HTMLElement);
    problem.hidden = false;
    setText(problem, reason);
  }

  private listenToDrops(): void {
    const veil = byId('drop', HTMLElement);
    window.addEventListener('dragover', (event) => {
      event.preventDefault();
      veil.hidden = false;
    });
    window.addEventListener('dragleave', (event) => {
      if (event.relatedTarget === null) veil.hidden = true;
    });
    window.addEventListener('drop', (event) => {
      event.preventDefault();
      veil.hidden = true;
      const file = event.dataTransfer?.files[0];
      if (file) this.take(file);
    });
  }
  private take(file: File): void {
    this.openFile(file).catch((error: unknown) =>
      this.refuse(`${plain(file.name, 60)} cannot be read: ${error instanceof Error ? error.message : String(error)}. Give a file model.txt.`));
  }
  private async openFile(file: File): Promise<void> {
    const bytes = new Uint8Array(await file.arrayBuffer()), text = new TextDecoder().decode(bytes);
    // Rays and errors in the page belong to its own model.
    await this.open(text, text === this.data.model ? this.data : { ...this.data, model: null, body: null, rays: [], validation: null, scene_title: '' }, initialState(), bytes);
  }

  private async savePng(): Promise<void> {
    if (!this.view) return;
    const { view } = this, { session, picture } = view;
    view.draw();
    const legend = session.maps.find(({ name }) => name === session.state.map)?.values(session.mapTools).scale ?? null;
    const image = await pngOf(picture.canvas, session, legend, metresPerPixel(view.size, view.camera.distance));
    if (image) download(image, 'image/png', fileName(session.runtime.model.info.title, 'png'));
  }
  private async saveGlb(): Promise<void> {
    if (!this.view) return;
    const { session, picture } = this.view;
    download(await glbOf(session, picture.positions, picture.colours), 'model/gltf-binary', fileName(session.runtime.model.info.title, 'glb'));
  }

  /** For scripts in the console of the browser, and for tests. */
  private expose(view: View): void {
    Object.assign(globalThis, {
      phynness: {
        get model() { return view.session.runtime.model; },
        get state() { return view.session.state; },
        get answer() { return view.session.answer; },
        get restless() { return view.session.restless; },
        /** Holds nodes: [{node, displacement}, ...] */
        hold: (tools: { node: number; displacement: V3 }[]) => {
          view.session.setTools(tools.map(({ node, displacement }) => ({ place: placeAt(node), displacement })));
          view.changed(true);
          view.draw();
        },
        set: (settings: Partial<State>) => {
          Object.assign(view.session.state, settings);
          view.changed(true);
          view.draw();
        },
        draw: () => view.draw(),
        /** Pixel of a node as it is displaced, and as it is drawn at smoothness 0. */
        project: (node: number) => {
          const { runtime } = view.session;
          return project(view.camera, view.size, add(runtime.point(node), runtime.displacement(node)));
        },
        point: (node: number) => view.session.runtime.point(node),
        positions: () => view.picture.positions,
        camera: () => view.camera,
      },
    });
  }
}

const page = new Page(pageDataOf(byId('phynness-data', HTMLScriptElement).textContent ?? '{}'));
page.start().catch((error: unknown) => {
  const problem = byId('problem', HTMLElement);
  problem.hidden = false;
  setText(problem, `The page cannot start: ${error instanceof Error ? error.message : String(error)}`);
});
