// The server of the workbench. What changes anything carries the token of the session.

let token = '';

async function ask(method, path, body) {
  const headers = method === 'GET' ? {} : { 'content-type': 'application/json', 'x-softdock': token };
  const text = body === undefined ? undefined : JSON.stringify(body);
  let response;
  try {
    response = await fetch(`/api/${path}`, { method, headers, body: text });
  } catch {
    throw new Error('The workbench does not answer: was it ended? Start `softdock workbench` again and reload.');
  }
  if (response.ok) return response;
  const answer = await response.json().catch(() => ({}));
  throw Object.assign(new Error(answer.error ?? `${response.status} ${response.statusText}`), { status: response.status });
}

export const id = encodeURIComponent;
export const get = async (path) => (await ask('GET', path)).json();
export const post = async (path, body) => {
  const response = await ask('POST', path, body);
  return response.status === 204 ? null : response.json();
};
export const end = (path) => ask('DELETE', path);

export async function session() {
  const about = await get('session');
  token = about.csrf;
  return about;
}

/** Columns of numbers, see `blob` in the server: rows, columns, then column after column. */
export async function columns(path) {
  const bytes = await (await ask('GET', path)).arrayBuffer();
  const [rows, count] = new Uint32Array(bytes, 0, 2);
  return Array.from({ length: count }, (_, k) => new Float64Array(bytes, 8 + 8 * rows * k, rows));
}

/** Starts a job and follows it; `told(kind, value)` hears everything but the result. */
export async function job(kind, args, told = () => {}, started = () => {}) {
  const { id: number } = await post('jobs', { kind, args });
  started(number);
  return new Promise((resolve, reject) => {
    const events = new EventSource(`/api/jobs/${number}/events`);
    const heard = (name) => (event) => told(name, JSON.parse(event.data));
    events.addEventListener('stage', heard('stage'));
    events.addEventListener('candidate', heard('candidate'));
    events.addEventListener('result', (event) => {
      events.close();
      resolve({ job: number, ...JSON.parse(event.data) });
    });
    events.addEventListener('error', (event) => {
      // Without data it is the connection, which the browser opens again, unless nobody knows the job any more.
      if (event.data === undefined && events.readyState !== EventSource.CLOSED) return;
      events.close();
      reject(new Error(event.data === undefined
        ? 'the workbench does not know this job any more, as after a start; ask again' : JSON.parse(event.data).error));
    });
  });
}
