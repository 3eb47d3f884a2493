// The bare state, until there is a page.
const show = async () => {
  const state = await (await fetch("/api/state")).json();
  document.getElementById("bench").textContent = JSON.stringify(state.steps);
};
new EventSource("/api/events").addEventListener("state", show);
