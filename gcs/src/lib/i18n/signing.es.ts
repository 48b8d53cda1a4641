// Textos de la firma, en español.
import type { signingEn } from './signing.en';

export const signingEs: Record<keyof typeof signingEn, string> = {
  'signing.title': 'Firma del vehículo {id}',
  'signing.unsigned': 'No firma: cualquiera a quien oiga puede mandarle.',
  'signing.signed': 'Firma con la clave «{key}». Lo que no firma se rechaza.',
  'signing.missing': 'Tiene que firmar y su clave no está en el servidor: no se le cree nada.',
  'signing.unproven': 'Enviadas y aún no mostradas por el vehículo: {keys}',
  'signing.private': 'A su enlace se le cree sin firma: nadie más puede alcanzarlo.',
  'signing.verified': 'Verificadas',
  'signing.accepted': 'Sin firma, aceptadas',
  'signing.refused': 'Rechazadas',
  'signing.refused.unsigned': 'sin firma',
  'signing.refused.wrong_key': 'otra clave',
  'signing.refused.replayed': 'repetidas',
  'signing.refused.old': 'demasiado viejas',
  'signing.refused.future': 'del futuro',
  'signing.setUp': 'Mantén pulsado: que firme',
  'signing.rotate': 'Mantén pulsado: darle otra clave',
  'signing.remove': 'Mantén pulsado: que no firme más',
  'signing.hint': 'La clave va por el enlace tal cual: solo por USB o en esta máquina, y solo desarmado.',
};
