// What becomes of a request for control, of a station or of a vehicle far away.

/** Who has control, and who asks for it. */
export interface ControlStanding {
  readonly has: boolean;
  readonly holder: string | null;
  readonly requestedBy: string | null;
  /** Whether the request is ours. */
  readonly isRequestOurs: boolean;
}

/** A request of ours. */
export interface ControlRequest {
  readonly state: 'none' | 'waiting' | 'declined';
  /** Who held control when it was made. */
  readonly askedOf: string | null;
}

export const NO_REQUEST: ControlRequest = { state: 'none', askedOf: null };

/** A request that is gone while the one who was asked keeps control was declined, unless another's took its place. */
export function followed(before: ControlRequest, now: ControlStanding): ControlRequest {
  const { has, holder, requestedBy, isRequestOurs } = now;
  if (has || holder === null) return NO_REQUEST;
  if (isRequestOurs) return { state: 'waiting', askedOf: holder };
  const isDeclined = before.state !== 'none' && requestedBy === null && holder === before.askedOf;
  return isDeclined ? { state: 'declined', askedOf: holder } : NO_REQUEST;
}
