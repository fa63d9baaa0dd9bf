// Files that come with the page: those inside it, and those that its address names, `?file=a.xml&file=b.xml`, relative to the page and from its own host.
// The first is shown, the second compared with it.

import { filesInside, unpacked } from "./inside";
import type { Loader } from "./load";

export async function openWhatCameAlong(loader: Loader): Promise<void> {
  const inside = filesInside().map((block) => ({ name: block.dataset["bsdf"]!, bytes: () => unpacked(block) }));
  const addresses = new URLSearchParams(location.search).getAll("file");
  const named = addresses.map((address) => ({ name: distinct(address, addresses), bytes: () => fetched(address) }));
  for (const [place, { name, bytes }] of [...inside, ...named].entries()) {
    loader.say(`reading ${name} …`);
    try {
      if (!(await loader.open(name, await bytes(), place))) return;
    } catch (error) {
      return loader.complain(`${name} cannot be read: ${error instanceof Error ? error.message : String(error)}`);
    }
  }
}

/** The last part of an address, or all of it where another one ends alike. */
function distinct(address: string, all: readonly string[]): string {
  const last = (text: string): string => text.slice(text.lastIndexOf("/") + 1);
  return decoded(all.filter((other) => last(other) === last(address)).length > 1 ? address : last(address));
}

/** As people write it; as it is if a % in it means nothing. */
function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

async function fetched(address: string): Promise<Uint8Array> {
  const url = new URL(address, document.baseURI);
  if (url.origin !== location.origin) throw new Error(`it is of another host, ${url.host}; only ${location.host} is asked`);
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${location.host} answers ${answer.status} ${answer.statusText}`);
  return new Uint8Array(await answer.arrayBuffer());
}
