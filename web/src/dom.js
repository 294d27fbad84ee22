// Elements; text is always text, never markup.

export const byId = (id) => document.getElementById(id);

export function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** A button that stays pressed while it is `on`. */
export function toggleButton(text, label, act) {
  const button = element('button', { type: 'button', 'aria-pressed': 'false', 'aria-label': label }, text);
  button.addEventListener('click', act);
  return button;
}

export const press = (button, on) => button.setAttribute('aria-pressed', String(on));
