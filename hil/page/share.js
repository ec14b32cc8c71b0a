// A session as a link or a file. A link holds everything behind its #, which no server ever sees.
export const VERSION = 1;
const MOST_LINK = 60000;

async function through(stream, bytes) {
  const writer = stream.writable.getWriter(), done = new Response(stream.readable).arrayBuffer();
  writer.write(bytes).catch(() => {});
  writer.close().catch(() => {});
  return new Uint8Array(await done);
}

function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 4096) text += String.fromCharCode(...bytes.subarray(i, i + 4096));
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

export async function link(session) {
  const text = JSON.stringify({ v: VERSION, ...session });
  const packed = await through(new CompressionStream("deflate-raw"), new TextEncoder().encode(text));
  const url = `${location.href.split("#")[0]}#s=${base64(packed)}`;
  return url.length <= MOST_LINK ? url : null;
}

const texts = value => Array.isArray(value) && value.every(each => typeof each === "string");

// What a link of another version has in common with this one's.
const nearest = ({ text, bench, set, observe, seed }) => ({
  text, bench: typeof bench === "string" ? bench : "emulated", set: texts(set) ? set : [], observe: observe === true, seed: Number.isSafeInteger(seed) && seed >= 0 ? seed : 1,
});

// The session of a link; a sentence is thrown for what is none.
export async function unlink(hash) {
  const found = /^#s=([\w-]+)$/.exec(hash);
  if (!found) throw new Error("This link holds no session: expected #s= and what a page wrote behind it. The page begins anew.");
  const broken = "This link is broken: part of the session in it is missing or was changed. The page begins anew.";
  let session;
  try {
    const bytes = Uint8Array.from(atob(found[1].replaceAll("-", "+").replaceAll("_", "/")), c => c.charCodeAt(0));
    session = JSON.parse(new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), bytes)));
  } catch {
    throw new Error(broken);
  }
  if (!Number.isInteger(session?.v)) throw new Error(broken);
  if (session.v !== VERSION) {
    const error = new Error(`This link was made by another version of the page (${session.v}; this one reads ${VERSION}). What it has in common is opened; the rest may differ.`);
    error.session = typeof session.text === "string" ? nearest(session) : null;
    if (!error.session) error.message += " It has no scene, so the page begins anew.";
    throw error;
  }
  if (typeof session.text !== "string" || typeof session.bench !== "string" || !texts(session.set)) throw new Error(broken);
  return session;
}

// What repeats a session: the first line of its file, and what the command line takes.
export function command({ bench, set, observe, seed }, name) {
  const sets = set.map(text => ` --set ${text}`).join("");
  return `hil run ${name} --bench ${bench}${sets}${observe ? " --observe" : ""} --seed ${seed}`;
}

export const file = (session, name) => `# ${command(session, name)}\n${session.text}`;

// A file again; one without the line is run on the default bench.
export function unfile(text) {
  const found = /^# hil run \S+ --bench (\S+)((?: --set \S+)*)( --observe)? --seed (\d+)\r?\n/.exec(text);
  if (!found) return { text, bench: "emulated", set: [], observe: false, seed: 1 };
  const set = [...found[2].matchAll(/ --set (\S+)/g)].map(m => m[1]);
  return { text: text.slice(found[0].length), bench: found[1], set, observe: Boolean(found[3]), seed: +found[4] };
}
