// What the server gives; a frozen page has it all inside.

const held = document.getElementById("frozen");
const FROZEN = held ? JSON.parse(held.textContent) : null;

export const frozen = FROZEN !== null;

export class Refusal extends Error {
  constructor(text, status) {
    super(text);
    this.status = status;
  }
}

export async function get(path, query = {}) {
  const tail = new URLSearchParams(query).toString();
  const address = tail ? `${path}?${tail}` : path;
  if (FROZEN) return FROZEN.answers[[path, ...Object.values(query)].join(" ")] ?? null;
  return answered(await fetch(`api/${address}`));
}

export async function post(path, content, signal) {
  if (FROZEN) throw new Refusal("frozen", 0);
  const body = JSON.stringify(content);
  const headers = { "content-type": "application/json" };
  return answered(await fetch(`api/${path}`, { method: "POST", headers, body, signal }));
}

export async function send(path, query, file) {
  const tail = new URLSearchParams(query).toString();
  return answered(await fetch(`api/${path}?${tail}`, { method: "POST", body: file }));
}

export async function wordsOf(language) {
  if (FROZEN) return FROZEN.words[language] ?? {};
  return answered(await fetch(`static/words/${language}.json`));
}

async function answered(response) {
  let content = null;
  const text = await response.text();
  try {
    content = JSON.parse(text);
  } catch {
    throw new Refusal(text || response.statusText || "…", response.status);
  }
  if (!response.ok) throw new Refusal(content?.error ?? response.statusText, response.status);
  return content;
}
