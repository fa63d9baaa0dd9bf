// What stands in the page itself, where `bsdftree view --export` put it: blocks of data, gzip as base64. In any other page there are none.

/** The bytes of a block. */
export async function unpacked(block: HTMLElement): Promise<Uint8Array<ArrayBuffer>> {
  const packed = Uint8Array.from(atob(block.textContent), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The block of the core. */
export function coreInside(): HTMLElement | null {
  return document.querySelector<HTMLElement>("script[data-core]");
}

/** The blocks of BSDFs, whose names are in `dataset.bsdf`. */
export function filesInside(): HTMLElement[] {
  return [...document.querySelectorAll<HTMLElement>("script[data-bsdf]")];
}
