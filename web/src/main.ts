// The page: views in the order of their tabs, one state for all of them.

import { openWhatCameAlong } from "./arrive";
import { Compare } from "./compare";
import { Controls } from "./controls";
import { found } from "./dom";
import { Dome } from "./dome";
import { listenToHelp } from "./help";
import { Loader } from "./load";
import { Lobes } from "./lobes";
import { Mosaic } from "./mosaic";
import { PolarMaps } from "./polar";
import { read } from "./readout";
import { Slice } from "./slice";
import { type State, Store } from "./state";
import { FileView } from "./summary";
import { TreeView } from "./tree";
import { Totals } from "./totals";
import { Tabs, type View } from "./view";

const store = new Store(draw);
const views: View[] = [
  new Lobes(store.set),
  new PolarMaps(store.set),
  new Slice(store.set),
  new Totals(store.set),
  new Mosaic(store.set),
  new TreeView(store.set),
  new Compare(store.set),
  new FileView(),
];
// The direction under the pointer is one of the view that was left.
const tabs = new Tabs(views, found("tabs", HTMLElement), found("stage", HTMLElement), () => store.set({ pointedAt: null }));
const controls = new Controls(store);
const dome = new Dome(found("dome", HTMLElement), (incident, moving) => store.set({ incident, moving }));
const loader = new Loader(store, found("message", HTMLElement));

function draw(state: State): void {
  found("page", HTMLElement).hidden = !state.first;
  found("empty", HTMLElement).hidden = state.first !== null;
  if (!state.first) return;
  controls.draw(state);
  dome.show(state.incident);
  tabs.visible.draw(state);
  read(found("readout", HTMLElement), state);
}

document.addEventListener("keydown", ({ key, target, ctrlKey, metaKey, altKey }) => {
  if (target instanceof HTMLInputElement || target instanceof HTMLSelectElement || ctrlKey || metaKey || altKey) return;
  if (key >= "1" && key <= "9") tabs.choose(Number(key) - 1);
});
loader.listen(found("file", HTMLInputElement), found("first-file", HTMLInputElement));
listenToHelp();
void openWhatCameAlong(loader);
