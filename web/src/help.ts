// The help overlay, and the choice of light or dark. In: keys and buttons. Out: nothing but looks.

import { found } from "./dom";

export function listenToHelp(): void {
  const help = found("help", HTMLDialogElement);
  found("show-help", HTMLButtonElement).addEventListener("click", () => help.showModal());
  // Beside the text, on what darkens the page.
  help.addEventListener("click", (event) => event.target === help && help.close());
  document.addEventListener("keydown", ({ key, target }) => {
    if (key === "?" && !(target instanceof HTMLInputElement)) help.open ? help.close() : help.showModal();
  });
  const root = document.documentElement;
  found("dark", HTMLButtonElement).addEventListener("click", () => {
    const isDark = root.style.colorScheme === "" ? matchMedia("(prefers-color-scheme: dark)").matches : root.style.colorScheme === "dark";
    root.style.colorScheme = isDark ? "light" : "dark";
  });
}
