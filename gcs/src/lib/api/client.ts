// The HTTP API, one method per call. Every failure is a ProblemError.
import { bodyOf, Http, type Options } from './http';
import type {
  ChangeSigning,
  CommandName,
  ComplexPart,
  FileParameter,
  FindingFix,
  FrameChange,
  Info,
  Landing,
  LandingAlternative,
  LandingMove,
  LandingRequest,
  LearnedPlane,
  LinkInfo,
  NamedCamera,
  NewLink,
  NewPlanDraft,
  DeclinedRequest,
  NewSession,
  Operation,
  Parameter,
  Plan,
  PlanDraft,
  PlanDrafts,
  PlanFileFormat,
  PlanFileNote,
  PlanFinding,
  PlanKind,
  CountedItems,
  PlanComparison,
  PlanOnBoard,
  RehearsalRequest,
  Separation,
  SeparationRequest,
  SerialPort,
  Session,
  SigningInfo,
  Spread,
  SpreadRequest,
  StatusText,
  Survey,
  SurveyRequest,
  VehicleCommands,
  VehicleProfile,
  VehicleState,
  VehicleControl,
  VehicleSummary,
  Way,
  WhatIfRequest,
  WhatIfs,
} from './types';

export type { CommandName, VehicleCommands } from './types';

/** How a command is sent. */
export type Acting = Options & {
  /** Although the mission on board may be a mixture or lead out of reach. */
  despiteMixedPlan?: boolean;
};

/** Notes about a plan file; an older server sends none. */
const notesOf = (answer: Response): PlanFileNote[] =>
  JSON.parse(answer.headers.get('vencejo-notes') ?? '[]') as PlanFileNote[];

export class Api extends Http {
  info = () => this.json<Info>('GET', '/info');
  openSession = (body: NewSession, signal: AbortSignal) => this.json<Session>('POST', '/session', body, { signal });
  takeControl = () => this.json<Partial<Session>>('POST', '/control/take', {});
  releaseControl = () => this.json<Partial<Session>>('POST', '/control/release', {});
  keepControl = (requested_by: string) =>
    this.json<Partial<Session>>('POST', '/control/keep', { requested_by } satisfies DeclinedRequest);
  requestControl = () => this.json<Partial<Session>>('POST', '/control/request', {});
  /** Control of a vehicle that another ground station of the fleet may have. */
  requestVehicle = (id: number) => this.json<VehicleControl>('POST', `/vehicles/${id}/control/request`, {});
  releaseVehicle = (id: number) => this.json<VehicleControl>('POST', `/vehicles/${id}/control/release`, {});
  keepVehicle = (id: number, requested_by: string) =>
    this.json<VehicleControl>('POST', `/vehicles/${id}/control/keep`, { requested_by } satisfies DeclinedRequest);

  links = () => this.json<LinkInfo[]>('GET', '/links');
  addLink = (body: NewLink) => this.json<LinkInfo>('POST', '/links', body);
  serialPorts = () => this.json<SerialPort[]>('GET', '/serial-ports');
  removeLink = (id: number) => this.json<unknown>('DELETE', `/links/${id}`);

  vehicles = () => this.json<VehicleSummary[]>('GET', '/vehicles');
  vehicle = (id: number) => this.json<VehicleState>('GET', `/vehicles/${id}`);
  /** Follows and commands the other vehicle with this number from now on. */
  followRival = (id: number) => this.json<unknown>('POST', `/vehicles/${id}/rival/follow`, {});
  texts = (id: number) => this.json<StatusText[]>('GET', `/vehicles/${id}/texts`);

  signing = (id: number) => this.json<SigningInfo>('GET', `/vehicles/${id}/signing`);
  /** Sets, changes or removes a vehicle's key; resolves when the vehicle confirms it. */
  changeSigning = (id: number, body: ChangeSigning) => this.json<SigningInfo>('POST', `/vehicles/${id}/signing`, body);

  /** Commands a vehicle; resolves when it has confirmed the command or shows its effect. */
  command = <Name extends CommandName>(
    id: number,
    name: Name,
    body: VehicleCommands[Name],
    { despiteMixedPlan = false, ...options }: Acting = {},
  ) => {
    const query = despiteMixedPlan ? '?despite_mixed_plan=true' : '';
    return this.json<unknown>('POST', `/vehicles/${id}/${name}${query}`, body, options);
  };

  sendPlan = (id: number, kind: PlanKind, plan: Plan) =>
    this.json<Operation>('PUT', `/vehicles/${id}/plan/${kind}`, plan);
  planOnBoard = (id: number, kind: PlanKind) => this.json<PlanOnBoard>('GET', `/vehicles/${id}/plan/${kind}`);
  /** How a plan differs from what is on board. */
  comparePlan = (id: number, plan: Plan) => this.json<PlanComparison>('POST', `/vehicles/${id}/plan/compare`, plan);
  readPlan = (id: number, kind: PlanKind) => this.json<Operation>('POST', `/vehicles/${id}/plan/${kind}/read`);
  /** A person has confirmed it. */
  clearPlan = (id: number, kind: PlanKind) =>
    this.confirmed([`clear-${kind}`], (options) =>
      this.json<Operation>('DELETE', `/vehicles/${id}/plan/${kind}`, undefined, options),
    );
  operation = <Result>(id: Operation['id'], options: Options = {}) =>
    this.json<Operation<Result>>('GET', `/operations/${encodeURIComponent(id)}`, undefined, options);
  cancelOperation = (id: Operation['id']) => this.json<unknown>('DELETE', `/operations/${encodeURIComponent(id)}`);

  async parsePlan(name: string, file: Blob): Promise<{ plan: Plan; notes: PlanFileNote[] }> {
    const answer = await this.request('POST', `/plan/parse?name=${encodeURIComponent(name)}`, file);
    return { plan: (await bodyOf(answer.json())) as Plan, notes: notesOf(answer) };
  }
  checkPlan = (plan: Plan, vehicle?: number) =>
    this.json<PlanFinding[]>('POST', '/plan/check', vehicle === undefined ? { plan } : { plan, vehicle });
  /** The path of a plan's mission, for drawing. */
  way = (plan: Plan, vehicle: number | undefined, clearance_m: number) =>
    this.json<Way>('POST', '/plan/way', { plan, vehicle: vehicle ?? null, clearance_m });
  /** Where planned flights come too near to each other. */
  separation = (asked: SeparationRequest) => this.json<Separation>('POST', '/plan/separation', asked);
  whatIf = (asked: WhatIfRequest) => this.json<WhatIfs>('POST', '/plan/what-if', asked);
  planFixes = (asked: RehearsalRequest) => this.json<FindingFix[]>('POST', '/plan/fixes', asked);
  /** Many flights of a plan; ending the request ends the flying. */
  spread = (asked: SpreadRequest, signal: AbortSignal) =>
    this.json<Spread>('POST', '/plan/rehearse/spread', asked, { signal });
  vehicleProfile = (id: number) => this.json<VehicleProfile>('GET', `/vehicles/${id}/profile`);
  /** Learns a plane from a recording of its flight, a `.tlog`. */
  async learnPlane(recording: Blob, vehicle?: number): Promise<LearnedPlane> {
    const query = vehicle === undefined ? '' : `?vehicle=${vehicle}`;
    const answer = await this.request('POST', `/plan/learn${query}`, recording, { signal: null });
    return (await bodyOf(answer.json())) as LearnedPlane;
  }
  designLanding = (asked: LandingRequest) => this.json<Landing>('POST', '/plan/landing', asked);
  landingAlternatives = (asked: LandingRequest) =>
    this.json<LandingAlternative[]>('POST', '/plan/landing/alternatives', asked);
  moveLanding = (asked: LandingMove) => this.json<Landing>('POST', '/plan/landing/move', asked);
  /** Items with their heights converted to another level. */
  countFrom = (asked: FrameChange) => this.json<CountedItems>('POST', '/plan/frame', asked);
  designSurvey = (asked: SurveyRequest) => this.json<Survey>('POST', '/plan/survey', asked);
  cameras = () => this.json<NamedCamera[]>('GET', '/plan/cameras');
  complexParts = (plan: Plan) => this.json<ComplexPart[]>('POST', '/plan/complex-items', plan);
  async formatPlan(plan: Plan, as: PlanFileFormat): Promise<{ file: Blob; notes: PlanFileNote[] }> {
    const answer = await this.request('POST', `/plan/format?as=${as}`, plan);
    return { file: await bodyOf(answer.blob()), notes: notesOf(answer) };
  }
  draft = () => this.json<PlanDrafts>('GET', '/draft');
  saveDraft = (draft: NewPlanDraft) => this.json<PlanDraft>('PUT', '/draft', draft);

  parseParams = (file: Blob) => this.json<FileParameter[]>('POST', '/params/parse', file);
  formatParams = (params: readonly FileParameter[]) => this.blob('POST', '/params/format', params);
  readParams = (id: number) => this.json<Operation>('GET', `/vehicles/${id}/params`);
  readParam = (id: number, name: string) =>
    this.json<Parameter>('GET', `/vehicles/${id}/params/${encodeURIComponent(name)}`);
  /** `acts`: what a person has confirmed of it. */
  setParam = (id: number, name: string, value: number, acts: readonly string[] = []) =>
    this.confirmed(acts, (options) =>
      this.json<Parameter>('PUT', `/vehicles/${id}/params/${encodeURIComponent(name)}`, { value }, options),
    );
}
