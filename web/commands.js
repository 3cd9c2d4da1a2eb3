// What the page asks of the console. The token stays in this tab; it is never put into an address.

const KEPT = "yarm-console-token";

/** Take the token out of the address, where it is after "#token=", so that nobody reads it there. */
export function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem(KEPT, given);
    history.replaceState(null, "", location.pathname);
  }
}

export const hasToken = () => Boolean(sessionStorage.getItem(KEPT));
export const setToken = (token) => sessionStorage.setItem(KEPT, token.trim());
export const forgetToken = () => sessionStorage.removeItem(KEPT);

/** Send a request; {success, message, status} whatever happens. */
export async function ask(path, body = {}) {
  const headers = { "Content-Type": "application/json" };
  if (hasToken()) headers.Authorization = `Bearer ${sessionStorage.getItem(KEPT)}`;
  try {
    const response = await fetch(path, { method: "POST", headers, body: JSON.stringify(body) });
    return { status: response.status, ...(await response.json()) };
  } catch (error) {
    return { status: 0, success: false, message: `the console does not answer: ${error.message}` };
  }
}
